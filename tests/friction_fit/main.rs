//! Friction laws fitted to measured motion and friction force.

mod laws;
mod spread;
mod squares;
mod ties;
mod velocity;

/// Evenly spread numbers within 1 around 0, the same every time.
pub struct Uniform(pub u64);

impl Uniform {
    pub fn draw(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}
