//! A grid: named axes in order (C order: the last one runs fastest) and fixed
//! values for the rest. Everything is checked here, once.

use crate::error::{Error, Result};
use crate::physics::ParamId;
use crate::physics::params::PARAM_COUNT;

#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub id: ParamId,
    pub values: Vec<f64>,
    /// Further parameters that take their values along the same axis: points of a sample.
    pub linked: Vec<(ParamId, Vec<f64>)>,
}

impl Axis {
    /// The parameters along the axis, each with its values.
    pub fn members(&self) -> impl Iterator<Item = (ParamId, &[f64])> {
        let linked = self.linked.iter().map(|(id, values)| (*id, &values[..]));
        std::iter::once((self.id, &self.values[..])).chain(linked)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    pub axes: Vec<Axis>,
    /// `None`: neither given nor defaulted.
    pub fixed: [Option<f64>; PARAM_COUNT],
}

impl Grid {
    /// Builds a grid from axes in order and fixed values, by name.
    pub fn new<S: AsRef<str>>(axes: &[(S, Vec<f64>)], fixed: &[(S, f64)]) -> Result<Grid> {
        Grid::with_sample(axes, &[], fixed)
    }

    /// The same with a sample as the last axis: parameters that take their values together.
    pub fn with_sample<S: AsRef<str>>(
        axes: &[(S, Vec<f64>)],
        sample: &[(S, Vec<f64>)],
        fixed: &[(S, f64)],
    ) -> Result<Grid> {
        let mut grid = Grid { axes: Vec::new(), fixed: [None; PARAM_COUNT] };
        for (name, values) in axes {
            let (id, values) = grid.read_axis(name.as_ref(), values)?;
            grid.axes.push(Axis { id, values, linked: Vec::new() });
        }
        for (place, (name, values)) in sample.iter().enumerate() {
            let (id, values) = grid.read_axis(name.as_ref(), values)?;
            match grid.axes.last_mut() {
                Some(last) if place > 0 => {
                    if values.len() != last.values.len() {
                        return Err(Error::BadOption {
                            name: "sample",
                            given: format!("{} values of {}", values.len(), name.as_ref()),
                            allowed: format!(
                                "as many as {} has: {}",
                                last.id.param().name,
                                last.values.len()
                            ),
                        });
                    }
                    last.linked.push((id, values));
                }
                _ => grid.axes.push(Axis { id, values, linked: Vec::new() }),
            }
        }
        for (name, value) in fixed {
            let id = ParamId::parse(name.as_ref())?;
            grid.refuse_twice(id, "a fixed value")?;
            grid.fixed[id as usize] = Some(id.param().check(*value, None)?);
        }
        for id in ParamId::all() {
            if grid.along(id).is_none() && grid.fixed[id as usize].is_none() {
                grid.fixed[id as usize] = id.param().default;
            }
        }
        grid.points()?;
        Ok(grid)
    }

    fn read_axis(&self, name: &str, values: &[f64]) -> Result<(ParamId, Vec<f64>)> {
        let id = ParamId::parse(name)?;
        self.refuse_twice(id, "an axis")?;
        let param = id.param();
        if values.is_empty() {
            return Err(Error::EmptyAxis { name: param.name.to_owned() });
        }
        let checked = values.iter().enumerate().map(|(i, v)| param.check(*v, Some(i)));
        Ok((id, checked.collect::<Result<_>>()?))
    }

    fn refuse_twice(&self, id: ParamId, second: &'static str) -> Result<()> {
        let first = match (self.along(id), self.fixed[id as usize]) {
            (Some(_), _) => "an axis",
            (_, Some(_)) => "a fixed value",
            _ => return Ok(()),
        };
        Err(Error::GivenTwice { name: id.param().name.to_owned(), first, second })
    }

    /// The values that a parameter takes along its axis, if it has one.
    pub fn along(&self, id: ParamId) -> Option<&[f64]> {
        let mut members = self.axes.iter().flat_map(Axis::members);
        members.find(|(member, _)| *member == id).map(|(_, values)| values)
    }

    pub fn shape(&self) -> Vec<usize> {
        self.axes.iter().map(|axis| axis.values.len()).collect()
    }

    /// Number of points, refused where it leaves what memory can address.
    pub fn points(&self) -> Result<usize> {
        let shape = self.shape();
        shape
            .iter()
            .try_fold(1usize, |n, len| n.checked_mul(*len))
            .filter(|n| *n <= isize::MAX as usize / 16)
            .ok_or(Error::GridTooLarge { sizes: shape })
    }

    /// Smallest and largest value that a parameter takes; `None` if it has none.
    pub fn bounds(&self, id: ParamId) -> Option<(f64, f64)> {
        match self.along(id) {
            Some(values) => values.iter().fold(None, |bounds, v| match bounds {
                None => Some((*v, *v)),
                Some((low, high)) => Some((v.min(low), v.max(high))),
            }),
            None => self.fixed[id as usize].map(|v| (v, v)),
        }
    }

    /// Whether every point keeps the promise of a plain one (see `Quantity`).
    pub fn is_plain(&self) -> bool {
        let always = |id, value: f64| self.bounds(id) == Some((value, value));
        let least = |id| self.bounds(id).map_or(f64::INFINITY, |b: (f64, f64)| b.0);
        let most = |id| self.bounds(id).map_or(f64::NEG_INFINITY, |b: (f64, f64)| b.1);
        always(ParamId::DriveLimit, f64::INFINITY)
            && always(ParamId::SpeedLimit, f64::INFINITY)
            && always(ParamId::Viscous, 0.0)
            && always(ParamId::Brake, 0.0)
            && always(ParamId::AnchorsAhead, 0.0)
            && least(ParamId::SlopeDeg) >= 0.0
            && least(ParamId::Segments) > most(ParamId::Moving)
    }
}
