//! Dense output: quartics over a step, and where they pass zero.

/// A quartic over a step; theta from 0 to 1.
#[derive(Clone, Copy)]
pub struct Quartic {
    c: [f64; 5],
}

/// Parts of a step within each of which a quartic is taken to turn once at most.
const PARTS: u32 = 8;
/// Halvings of a bracket: beyond them it holds two neighbouring numbers.
const HALVINGS: u32 = 60;

impl Quartic {
    pub fn constant(value: f64) -> Quartic {
        Quartic { c: [value, 0.0, 0.0, 0.0, 0.0] }
    }

    /// From both values, `dt` times both slopes, and what the stages say beyond
    /// the cubic of these (Hairer, Norsett and Wanner, Solving Ordinary
    /// Differential Equations I, II.6).
    pub fn new((from, to): (f64, f64), (start, end): (f64, f64), beyond: f64) -> Quartic {
        let rise = to - from;
        let first = start - rise;
        let second = rise - end - first;
        let square = second + beyond - first;
        Quartic { c: [from, start, square, -second - 2.0 * beyond, beyond] }
    }

    pub fn at(&self, theta: f64) -> f64 {
        self.c.iter().rev().fold(0.0, |sum, c| sum * theta + c)
    }

    pub fn slope(&self, theta: f64) -> f64 {
        let [_, c1, c2, c3, c4] = self.c;
        c1 + theta * (2.0 * c2 + theta * (3.0 * c3 + theta * (4.0 * c4)))
    }

    /// `value` less the quartic, times `direction`.
    pub fn short_of(&self, value: f64, direction: f64) -> Quartic {
        let mut c = self.c.map(|c| -direction * c);
        c[0] += direction * value;
        Quartic { c }
    }

    /// The same, seen along `direction`.
    pub fn along(&self, direction: f64) -> Quartic {
        Quartic { c: self.c.map(|c| direction * c) }
    }

    /// Where the slope passes zero, each from which part of the step.
    fn turns(&self) -> impl Iterator<Item = f64> {
        parts().filter_map(move |(a, b)| {
            let (rises, falls) = (self.slope(a), self.slope(b));
            (rises * falls < 0.0).then(|| halve(a, b, |theta| self.slope(theta) * rises))
        })
    }

    /// The largest size within the step where the slope passes zero.
    pub fn peak(&self) -> Option<f64> {
        self.turns().map(|theta| self.at(theta).abs()).reduce(f64::max)
    }

    /// The first theta where the quartic falls below zero, from above or from zero
    /// itself; a dip between two positive values counts.
    pub fn fall(&self) -> Option<f64> {
        let mut turns = self.turns().peekable();
        for (a, b) in parts() {
            let turn = turns.next_if(|turn| *turn <= b);
            // What starts from zero has its root behind it.
            let low = if a == 0.0 && self.c[0] <= 0.0 { self.start(b) } else { a };
            for end in turn.into_iter().filter(|turn| *turn > low).chain([b]) {
                if self.at(end) < 0.0 {
                    return Some(halve(low, end, |theta| self.at(theta)));
                }
            }
        }
        None
    }

    /// A theta before `end` where what starts from zero has risen, 0 if nowhere.
    fn start(&self, end: f64) -> f64 {
        (1..=HALVINGS)
            .map(|i| end * 0.5f64.powi(i as i32))
            .find(|theta| self.at(*theta) > 0.0)
            .unwrap_or(0.0)
    }
}

fn parts() -> impl Iterator<Item = (f64, f64)> {
    let at = |i: u32| f64::from(i) / f64::from(PARTS);
    (0..PARTS).map(move |i| (at(i), at(i + 1)))
}

/// The end of what is positive in [low, high], from above.
fn halve(mut low: f64, mut high: f64, value: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if value(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}
