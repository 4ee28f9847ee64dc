//! Symmetry and scaling.

use super::*;

#[test]
fn friction_is_odd_in_speed() {
    let mut random = Random(8);
    for _ in 0..1000 {
        let v = random.log(1e-9, 1e6);
        let at = |v| [(MuCoulomb, 0.3), (Viscous, 0.7), (SlopeDeg, 12.0), (Speed, v)];
        assert_eq!(value::<FrictionForce>(&at(v)), -value::<FrictionForce>(&at(-v)));
        near(value::<FrictionForce>(&at(v)), 0.3 * MG * 12f64.to_radians().cos() + 0.7 * v, 1e-14);
    }
    let rest = [(MuCoulomb, 0.3), (Speed, 0.0)];
    assert!(value::<FrictionForce>(&rest).is_nan());
    assert_eq!(status::<FrictionForce>(&rest), Status::SetValued);
}

/// Factors by which a scaled robot's parameters and quantities change.
struct Scale {
    mass: f64,
    length: f64,
    time: f64,
}

impl Scale {
    fn of(&self, unit: &str) -> f64 {
        let speed = self.length / self.time;
        let force = self.mass * speed / self.time;
        match unit {
            "1" | "deg" => 1.0,
            "kg" => self.mass,
            "m" => self.length,
            "s" => self.time,
            "m/s" => speed,
            "m/s^2" => speed / self.time,
            "N" => force,
            "J" => force * self.length,
            "W" => force * speed,
            "N s/m" => force / speed,
            other => panic!("unit {other} has no scale"),
        }
    }
}

fn scales_exactly<Q: Quantity>(given: Given) {
    let expected = value::<Q>(given);
    for (mass, length, time) in
        [(2.0, 1.0, 1.0), (1.0, 4.0, 1.0), (1.0, 1.0, 0.5), (8.0, 0.25, 4.0)]
    {
        let scale = Scale { mass, length, time };
        let scaled: Vec<_> =
            given.iter().map(|(id, v)| (*id, v * scale.of(id.param().unit))).collect();
        let got = value::<Q>(&scaled) / scale.of(Q::INFO.unit);
        let name = Q::INFO.name;
        assert_eq!(got.to_bits(), expected.to_bits(), "{name}: {got} for {expected} at {given:?}");
    }
}

#[test]
fn powers_of_two_scale_without_rounding() {
    let mut random = Random(10);
    for _ in 0..400 {
        let k = random.whole(1, 4);
        let optional = |random: &mut Random, low, high, none: f64| {
            if random.one_in(2) { none } else { random.log(low, high) }
        };
        let given = [
            (MuStatic, random.log(0.1, 2.0)),
            (MuCoulomb, random.log(0.02, 1.0)),
            (Moving, k),
            (Segments, k + random.whole(1, 30)),
            (SlopeDeg, random.between(-10.0, 30.0)),
            (AnchorWeight, random.unit()),
            (Mass, random.log(0.01, 10.0)),
            (Gravity, random.log(1.0, 20.0)),
            (Stroke, random.log(1e-3, 1.0)),
            (Viscous, optional(&mut random, 0.01, 100.0, 0.0)),
            (DriveLimit, optional(&mut random, 0.1, 100.0, f64::INFINITY)),
            (SpeedLimit, optional(&mut random, 1e-3, 10.0, f64::INFINITY)),
            (WallForce, optional(&mut random, 0.1, 100.0, 0.0)),
            (WallRelease, random.unit()),
            (AnchorsAhead, random.whole(0, 1)),
            (Brake, random.whole(0, 1)),
            (CoulombTerm, random.whole(0, 1)),
            (Time, random.log(1e-3, 10.0)),
            (Speed, random.between(-1.0, 1.0)),
            (SegmentsMax, 200.0),
        ];
        macro_rules! each {
            ($($quantity:ident),+ $(,)?) => { $(scales_exactly::<$quantity>(&given);)+ };
        }
        locosweep::for_each_quantity!(each);
    }
}
