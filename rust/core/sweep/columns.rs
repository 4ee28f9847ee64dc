//! The parameters of a stretch of cells, laid out for the kernels.
//!
//! The trailing axes (the inner block) are expanded once per sweep into columns
//! of consecutive cells; the leading ones stay constant over such a row.

use super::grid::Axis;
use crate::lane::Pack;
use crate::physics::ParamId;
use crate::physics::point::{COLUMNS, Point, columns};

/// Cells that a kernel call covers at most: results stay in the first cache.
pub const BLOCK: usize = 2048;
/// Columns reach this far beyond the last cell, so that the last pack may too.
pub const PADDING: usize = 32;
/// Rows at least this long amortise what is done per row.
const ROW: usize = 512;
/// Expanded columns never grow beyond this many cells by a further axis.
const TABLE: usize = 1 << 20;

/// Which parameters may vary within a row, as far as a kernel was compiled for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Vary {
    SlopeAndSegments,
    /// Also the two friction coefficients.
    Main,
    Any,
}

impl Vary {
    pub const SLOPE_AND_SEGMENTS: u8 = 0;
    pub const MAIN: u8 = 1;
    pub const ANY: u8 = 2;

    pub fn of(axes: &[&Axis]) -> Vary {
        let all_in = |set: &[ParamId]| axes.iter().all(|axis| set.contains(&axis.id));
        if all_in(&[ParamId::SlopeDeg, ParamId::Segments]) {
            Vary::SlopeAndSegments
        } else if all_in(&MAIN_PARAMS) {
            Vary::Main
        } else {
            Vary::Any
        }
    }
}

const MAIN_PARAMS: [ParamId; 4] =
    [ParamId::MuStatic, ParamId::MuCoulomb, ParamId::SlopeDeg, ParamId::Segments];

/// Whether a kernel for `vary` reads `column` cell by cell.
#[inline(always)]
pub const fn is_wide(vary: u8, column: usize) -> bool {
    let id = column / 2;
    let slope_or_segments = id == ParamId::SlopeDeg as usize || id == ParamId::Segments as usize;
    match vary {
        Vary::SLOPE_AND_SEGMENTS => slope_or_segments,
        Vary::MAIN => {
            slope_or_segments
                || id == ParamId::MuStatic as usize
                || id == ParamId::MuCoulomb as usize
        }
        _ => true,
    }
}

/// The expanded inner block and what lies outside of it.
#[derive(Debug)]
pub struct Layout {
    pub row: usize,
    pub vary: Vary,
    inner: Vec<(usize, Vec<f64>)>,
    /// Column pairs of each outer axis, by axis value, first axis first.
    outer: Vec<(ParamId, Vec<[f64; 2]>)>,
}

impl Layout {
    pub fn new(axes: &[&Axis]) -> Layout {
        let (mut row, mut split) = (1, axes.len());
        while split > 0 {
            let next = row * axes[split - 1].values.len();
            if row > 1 && (row >= ROW || next > TABLE) {
                break;
            }
            row = next;
            split -= 1;
        }
        let (outer, inner) = axes.split_at(split);
        let mut layout =
            Layout { row, vary: Vary::of(inner), inner: Vec::new(), outer: Vec::new() };
        let mut repeat = row;
        for axis in inner {
            repeat /= axis.values.len();
            let pairs: Vec<[f64; 2]> = axis.values.iter().map(|v| columns(axis.id, *v)).collect();
            for derived in 0..2 {
                let mut column = Vec::with_capacity(row + PADDING);
                while column.len() < row {
                    for pair in &pairs {
                        column.extend(std::iter::repeat_n(pair[derived], repeat));
                    }
                }
                // Padding holds valid numbers: their results are thrown away.
                column.resize(row + PADDING, pairs[pairs.len() - 1][derived]);
                layout.inner.push((2 * axis.id as usize + derived, column));
            }
        }
        for axis in outer {
            let pairs = axis.values.iter().map(|v| columns(axis.id, *v)).collect();
            layout.outer.push((axis.id, pairs));
        }
        layout
    }

    /// Bytes that the expanded columns take.
    pub fn bytes(axes: &[&Axis]) -> usize {
        let (mut row, mut wide) = (1usize, 0usize);
        for axis in axes.iter().rev() {
            let next = row.saturating_mul(axis.values.len());
            if row > 1 && (row >= ROW || next > TABLE) {
                break;
            }
            row = next;
            wide += 2;
        }
        wide * (row + PADDING) * size_of::<f64>()
    }
}

/// What one thread needs to point a kernel at a stretch of cells.
pub struct Cursor<'a> {
    layout: &'a Layout,
    /// A pack's worth of each constant.
    constants: Vec<[f64; PADDING]>,
    /// Constants written out over a block, for kernels that read them as columns.
    written: Vec<Vec<f64>>,
}

impl<'a> Cursor<'a> {
    pub fn new(layout: &'a Layout, fixed: &[f64; COLUMNS]) -> Cursor<'a> {
        Cursor {
            layout,
            constants: fixed.iter().map(|v| [*v; PADDING]).collect(),
            written: vec![Vec::new(); COLUMNS],
        }
    }

    /// Columns of the cells from `start` on; they end with the row.
    pub fn at(&mut self, start: usize, vary: u8) -> Columns<'_> {
        let (mut index, offset) = (start / self.layout.row, start % self.layout.row);
        for (id, pairs) in self.layout.outer.iter().rev() {
            let pair = pairs[index % pairs.len()];
            index /= pairs.len();
            self.constants[id.main()] = [pair[0]; PADDING];
            self.constants[id.derived()] = [pair[1]; PADDING];
        }
        if vary != Vary::ANY {
            for column in (0..COLUMNS).filter(|c| is_wide(vary, *c)) {
                let value = self.constants[column][0];
                let written = &mut self.written[column];
                if written.first().map(|v| v.to_bits()) != Some(value.to_bits()) {
                    written.clear();
                    written.resize(BLOCK + PADDING, value);
                }
            }
        }
        let mut columns = Columns { data: [&[]; COLUMNS], mask: [0; COLUMNS] };
        for column in 0..COLUMNS {
            let wide = vary != Vary::ANY && is_wide(vary, column);
            columns.data[column] =
                if wide { &self.written[column] } else { &self.constants[column] };
        }
        for (column, values) in &self.layout.inner {
            columns.data[*column] = &values[offset..];
            columns.mask[*column] = usize::MAX;
        }
        columns
    }
}

/// One slice per column: as long as the stretch where it varies, else constant.
#[derive(Clone)]
pub struct Columns<'a> {
    pub data: [&'a [f64]; COLUMNS],
    /// All ones where the column runs with the cell, zero where it is constant.
    pub mask: [usize; COLUMNS],
}

impl<'a> Columns<'a> {
    /// Replaces a column by one that runs with the cells.
    pub fn replace(&mut self, column: usize, values: &'a [f64]) {
        self.data[column] = values;
        self.mask[column] = usize::MAX;
    }

    /// A pack of points from cell `i` on. Columns not in `used` are left NaN,
    /// so that the compiler drops them.
    #[inline(always)]
    pub fn gather<P: Pack, const VARY: u8>(
        &self,
        token: P::Token,
        i: usize,
        used: u64,
    ) -> Point<P> {
        Point::gather(
            #[inline(always)]
            |c| {
                if used >> (c / 2) & 1 == 0 {
                    P::splat(token, f64::NAN)
                } else if VARY == Vary::ANY {
                    P::load(token, &self.data[c][i & self.mask[c]..])
                } else if is_wide(VARY, c) {
                    P::load(token, &self.data[c][i..])
                } else {
                    P::splat(token, self.data[c][0])
                }
            },
        )
    }

    /// Cell `i` as a scalar point.
    pub fn point(&self, i: usize) -> Point<f64> {
        Point::gather(|c| self.data[c][i & self.mask[c]])
    }
}
