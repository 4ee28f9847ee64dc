//! Sine and cosine of whole turns, over lanes. Counted in turns, an argument
//! loses its whole part exactly, so that the error does not grow with it.

use super::Lane;

/// sin(2 pi x), exact at multiples of a quarter; within 1 ulp for |x| < 2^51.
#[inline(always)]
pub fn sin_turns<L: Lane>(x: L) -> L {
    x.shared(
        #[inline(always)]
        || sin_turns_here(x),
    )
}

#[inline(always)]
fn sin_turns_here<L: Lane>(x: L) -> L {
    let quarter = Quarter::of(x);
    let size = L::select(quarter.odd, quarter.cos(), quarter.sin());
    // Quarters -2, -1, 0, 1, 2: -sin, -cos, sin, cos, -sin.
    let negative = L::or(quarter.n.lt(x.splat(-0.5)), quarter.n.gt(x.splat(1.5)));
    L::select(negative, -size, size)
}

/// cos(2 pi x), exact at multiples of a quarter; within 1 ulp for |x| < 2^51.
#[inline(always)]
pub fn cos_turns<L: Lane>(x: L) -> L {
    x.shared(
        #[inline(always)]
        || cos_turns_here(x),
    )
}

#[inline(always)]
fn cos_turns_here<L: Lane>(x: L) -> L {
    let quarter = Quarter::of(x);
    let size = L::select(quarter.odd, quarter.sin(), quarter.cos());
    // Quarters -2, -1, 0, 1, 2: -cos, sin, cos, -sin, -cos.
    let negative = L::or(quarter.n.lt(x.splat(-1.5)), quarter.n.gt(x.splat(0.5)));
    L::select(negative, -size, size)
}

/// The nearest multiple of a quarter turn, and what is left of an eighth.
struct Quarter<L: Lane> {
    /// From -2 to 2.
    n: L,
    odd: L::Mask,
    y: L,
}

impl<L: Lane> Quarter<L> {
    #[inline(always)]
    fn of(x: L) -> Self {
        let r = x - x.round();
        let n = (r * 4.0).round();
        let one = x.splat(1.0);
        let odd = L::and(n.abs().le(one), one.le(n.abs()));
        Quarter { n, odd, y: n.mul_add(x.splat(-0.25), r) }
    }

    /// sin(2 pi y): Taylor to y^17, what is left out is below 1e-19.
    #[inline(always)]
    fn sin(&self) -> L {
        let y = self.y;
        let z = y * y;
        let mut tail = y.splat(0.104_229_162_208_139_84);
        for c in [
            -0.718_122_301_778_500_6,
            3.819_952_584_848_282,
            -15.094_642_576_822_99,
            42.058_693_944_897_655,
            -76.705_859_753_061_39,
            81.605_249_276_075_06,
            -41.341_702_240_399_76,
        ] {
            tail = tail.mul_add(z, y.splat(c));
        }
        // 2 pi in two parts.
        let turn = y.splat(std::f64::consts::TAU);
        let angle = y * turn;
        let fine = y.mul_add(turn, -angle) + y * 2.449_293_598_294_706_4e-16;
        angle + (y * z).mul_add(tail, fine)
    }

    /// cos(2 pi y): Taylor to y^16, what is left out is below 3e-18.
    #[inline(always)]
    fn cos(&self) -> L {
        let z = self.y * self.y;
        let mut tail = z.splat(0.282_005_968_455_791_23);
        for c in [
            -1.714_390_711_088_672,
            7.903_536_371_318_469,
            -26.426_256_783_374_4,
            60.244_641_371_876_66,
            -85.456_817_206_693_73,
            64.939_394_022_668_3,
            -19.739_208_802_178_716,
        ] {
            tail = tail.mul_add(z, z.splat(c));
        }
        z.mul_add(tail, z.splat(1.0))
    }
}
