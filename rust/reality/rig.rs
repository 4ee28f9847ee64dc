//! What stands on the table: masses, friction levels, slope and drive.

/// A robot's head and body, or a bench with one degree of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rig {
    pub segments: f64,
    /// kg of one segment, or kg m^2 on a rotary bench.
    pub mass: f64,
    pub gravity: f64,
    pub mu_coulomb: f64,
    /// N or N m; in place of `mu_coulomb`.
    pub coulomb_force: Option<f64>,
    pub viscous: f64,
    pub slope_deg: f64,
    pub gain: f64,
    pub limit: f64,
    /// N m; its presence makes the bench rotary.
    pub gravity_torque: Option<f64>,
    /// The drive takes effect this much later than its samples say, s.
    pub clock: f64,
}

impl Rig {
    /// Coulomb level at the nominal slope, the one that levels in effects refer to.
    pub fn reference_level(&self) -> f64 {
        self.coulomb_force.unwrap_or_else(|| {
            self.mu_coulomb * self.mass * self.gravity * self.slope_deg.to_radians().cos()
        })
    }

    pub fn is_rotary(&self) -> bool {
        self.gravity_torque.is_some()
    }
}
