//! The parameters of a stretch of cells, laid out for the kernels.
//!
//! The trailing axes (the inner block) are expanded once per sweep into columns
//! of consecutive cells; the leading ones stay constant over such a row.

use super::grid::Axis;
use crate::lane::Pack;
use crate::physics::ParamId;
use crate::physics::point::{COLUMNS, Point, columns};

/// Cells that a kernel call covers at most.
pub const BLOCK: usize = 4096;
/// The widest pack.
pub const PADDING: usize = 32;
/// Columns reach this far beyond the last cell: a stretch may be rounded up to
/// whole packs, and a reader asks for one pack more than its cells.
const OVERHANG: usize = 2 * PADDING;
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
        let ids: Vec<ParamId> =
            axes.iter().flat_map(|axis| axis.members().map(|(id, _)| id)).collect();
        let all_in = |set: &[ParamId]| ids.iter().all(|id| set.contains(id));
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
    /// By column; empty where it is constant over a row.
    inner: Vec<Vec<f64>>,
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
        let mut layout = Layout {
            row,
            vary: Vary::of(inner),
            inner: vec![Vec::new(); COLUMNS],
            outer: Vec::new(),
        };
        let mut repeat = row;
        for axis in inner {
            repeat /= axis.values.len();
            for (id, values) in axis.members() {
                let pairs: Vec<[f64; 2]> = values.iter().map(|v| columns(id, *v)).collect();
                for derived in 0..2 {
                    let mut column = Vec::with_capacity(row + OVERHANG);
                    while column.len() < row {
                        for pair in &pairs {
                            column.extend(std::iter::repeat_n(pair[derived], repeat));
                        }
                    }
                    // Padding holds valid numbers: their results are thrown away.
                    column.resize(row + OVERHANG, pairs[pairs.len() - 1][derived]);
                    layout.inner[2 * id as usize + derived] = column;
                }
            }
        }
        // A sample is the last axis, which is always an inner one.
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
            wide += 2 * axis.members().count();
        }
        wide * (row + OVERHANG) * size_of::<f64>()
    }
}

/// What one thread needs to point a kernel at a stretch of cells.
pub struct Cursor<'a> {
    layout: &'a Layout,
    /// A pack's worth of each constant.
    constants: Vec<[f64; PADDING]>,
    /// Constants written out over a block, for kernels that read them as columns.
    written: Vec<Vec<f64>>,
    /// Row and vary class that the two were last set for.
    set_for: Option<(usize, u8)>,
}

impl<'a> Cursor<'a> {
    pub fn new(layout: &'a Layout, fixed: &[f64; COLUMNS]) -> Cursor<'a> {
        Cursor {
            layout,
            constants: fixed.iter().map(|v| [*v; PADDING]).collect(),
            written: vec![Vec::new(); COLUMNS],
            set_for: None,
        }
    }

    /// Columns of the cells from `start` on; they end with the row.
    pub fn at(&mut self, start: usize, vary: u8) -> Columns<'_> {
        let (row, offset) = (start / self.layout.row, start % self.layout.row);
        if self.set_for != Some((row, vary)) {
            self.set_constants(row, vary);
            self.set_for = Some((row, vary));
        }
        Columns {
            layout: self.layout,
            constants: &self.constants,
            written: if vary == Vary::ANY { &[] } else { &self.written },
            offset,
            replaced: None,
        }
    }
}

impl Cursor<'_> {
    fn set_constants(&mut self, row: usize, vary: u8) {
        let mut index = row;
        for (id, pairs) in self.layout.outer.iter().rev() {
            let pair = pairs[index % pairs.len()];
            index /= pairs.len();
            self.constants[id.main()] = [pair[0]; PADDING];
            self.constants[id.derived()] = [pair[1]; PADDING];
        }
        if vary == Vary::ANY {
            return;
        }
        let len = self.layout.row.min(BLOCK) + OVERHANG;
        let inner = &self.layout.inner;
        // Called once per row: no other parameter is read cell by cell here.
        let wide = MAIN_PARAMS.iter().flat_map(|id| [id.main(), id.derived()]);
        for column in wide.filter(|c| is_wide(vary, *c) && inner[*c].is_empty()) {
            let value = self.constants[column][0];
            let written = &mut self.written[column];
            if written.first().map(|v| v.to_bits()) != Some(value.to_bits()) {
                written.clear();
                written.resize(len, value);
            }
        }
    }
}

/// The columns of a stretch of cells, looked up when asked for.
#[derive(Clone, Copy)]
pub struct Columns<'a> {
    layout: &'a Layout,
    constants: &'a [[f64; PADDING]],
    /// Empty for kernels that take any column, wide or constant.
    written: &'a [Vec<f64>],
    offset: usize,
    /// A parameter that has its own two columns for these cells.
    replaced: Option<(ParamId, [&'a [f64]; 2])>,
}

impl<'a> Columns<'a> {
    /// The same cells with another pair of columns for one parameter.
    pub fn replacing(mut self, id: ParamId, columns: [&'a [f64]; 2]) -> Self {
        self.replaced = Some((id, columns));
        self
    }

    /// The numbers of a column from cell `start` on, and whether they run with
    /// the cell (else they are a pack of one constant).
    #[inline(always)]
    fn column(&self, column: usize, start: usize) -> (&'a [f64], bool) {
        match self.replaced {
            Some((id, columns)) if id as usize == column / 2 => {
                return (&columns[column % 2][start..], true);
            }
            _ => {}
        }
        let inner = &self.layout.inner[column];
        if !inner.is_empty() {
            return (&inner[self.offset + start..], true);
        }
        match self.written.get(column) {
            Some(written) if !written.is_empty() => (&written[start..], true),
            _ => (&self.constants[column], false),
        }
    }

    /// A pack of one column from cell `start` on.
    #[inline(always)]
    pub fn load<P: Pack>(&self, token: P::Token, column: usize, start: usize) -> P {
        let (numbers, runs) = self.column(column, start);
        if runs { P::load(token, numbers) } else { P::broadcast(token, numbers[0]) }
    }

    /// A reader of packs over the cells from `start` on, for a kernel that uses
    /// the parameters in `used` and was compiled for `VARY`.
    #[inline(always)]
    pub fn reader<P: Pack, const VARY: u8>(
        &self,
        token: P::Token,
        used: u128,
        start: usize,
        len: usize,
    ) -> Reader<'a, P, VARY> {
        let found = self.find(used, start);
        if VARY == Vary::ANY {
            let constant = found.map(
                #[inline(always)]
                |_, _| P::broadcast(token, f64::NAN),
            );
            return Reader { token, used, wide: found, constant };
        }
        let wide = found.map(
            #[inline(always)]
            |c, (column, _)| (Reader::<P, VARY>::run(used, len, c, || column), 0),
        );
        let constant = found.map(
            #[inline(always)]
            |c, (column, _)| Reader::<P, VARY>::constant(token, used, c, || column),
        );
        Reader { token, used, wide, constant }
    }

    /// The same, with the columns looked up in place: for a loop that carries a value on.
    /// Of numbers that came from a call the compiler does the arithmetic one by one, which
    /// takes as long but lengthens the chain. It doubles the code of a kernel.
    #[inline(always)]
    pub fn reader_in_place<P: Pack, const VARY: u8>(
        &self,
        token: P::Token,
        used: u128,
        start: usize,
        len: usize,
    ) -> Reader<'a, P, VARY> {
        let wide = Point::gather(
            #[inline(always)]
            |c| {
                let column = Reader::<P, VARY>::run(
                    used,
                    len,
                    c,
                    #[inline(always)]
                    || self.column(c, start).0,
                );
                (column, 0)
            },
        );
        let constant = Point::gather(
            #[inline(always)]
            |c| {
                Reader::<P, VARY>::constant(
                    token,
                    used,
                    c,
                    #[inline(always)]
                    || self.column(c, start).0,
                )
            },
        );
        Reader { token, used, wide, constant }
    }

    /// Where the used columns lie, and the bits of a cell's number that count in each. Looked up
    /// by a call: written out, the look-ups would be half of many a kernel.
    #[inline(never)]
    fn find(&self, used: u128, start: usize) -> Point<(&'a [f64], usize)> {
        Point::gather(
            #[inline(always)]
            |c| {
                if used >> (c / 2) & 1 == 0 {
                    return (&[][..], 0);
                }
                let (column, runs) = self.column(c, start);
                (column, if runs { usize::MAX } else { 0 })
            },
        )
    }

    /// All columns of cell `i`.
    pub fn row(&self, i: usize) -> [f64; COLUMNS] {
        std::array::from_fn(|c| {
            let (column, runs) = self.column(c, 0);
            column[if runs { i } else { 0 }]
        })
    }
}

/// Points of consecutive cells, a pack at a time.
pub struct Reader<'a, P: Pack, const VARY: u8> {
    token: P::Token,
    used: u128,
    /// Each column, and the bits of a cell's number that count in it where any may vary.
    wide: Point<(&'a [f64], usize)>,
    constant: Point<P>,
}

impl<'a, P: Pack, const VARY: u8> Reader<'a, P, VARY> {
    /// The numbers of a column that runs with the cell, for a kernel that knows which do.
    #[inline(always)]
    fn run(used: u128, len: usize, c: usize, column: impl FnOnce() -> &'a [f64]) -> &'a [f64] {
        if used >> (c / 2) & 1 == 0 || !is_wide(VARY, c) {
            return &[];
        }
        // One length for all: bounds are checked here, not per pack.
        &column()[..len + P::LANES]
    }

    /// The number of a column that does not. Unused columns are NaN, which lets the
    /// compiler drop them.
    #[inline(always)]
    fn constant(token: P::Token, used: u128, c: usize, column: impl FnOnce() -> &'a [f64]) -> P {
        let known = used >> (c / 2) & 1 == 1 && !is_wide(VARY, c);
        P::broadcast(token, if known { column()[0] } else { f64::NAN })
    }

    #[inline(always)]
    pub fn at(&self, i: usize) -> Point<P> {
        self.wide.zip(
            &self.constant,
            #[inline(always)]
            |c, (wide, bits), constant| {
                if self.used >> (c / 2) & 1 == 0 || !is_wide(VARY, c) {
                    constant
                } else if VARY == Vary::ANY {
                    P::load(self.token, &wide[i & bits..])
                } else {
                    P::load(self.token, &wide[i..])
                }
            },
        )
    }
}
