//! Jacobi rotations of one matrix on the floating-point unit of Armv7E-M. Every operation is that of
//! `jacobi`, in its order; only the sign of a zero that is then added to a root differs.

#![allow(unsafe_code)]

use core::arch::asm;

use super::matrix::Matrix;
use crate::backend::lane::Lane;

/// A rotation that removes the element `$off` between the diagonal elements `$a` and `$b`, and turns the other
/// two elements and the columns `$x` and `$y`.
macro_rules! rotation {
    ($a:literal $b:literal $off:literal, $p:literal $q:literal,
     $x0:literal $y0:literal, $x1:literal $y1:literal, $x2:literal $y2:literal) => {
        concat!(
            // The tangent in s23: twice the element over distance and length, with the distance's sign.
            "vsub.f32 s20, ", $b, ", ", $a, "; vadd.f32 s23, ", $off, ", ", $off, "\n",
            "vmul.f32 s24, s20, s20; vmla.f32 s24, s23, s23; vsqrt.f32 s24, s24\n",
            "vcmp.f32 s20, #0.0; vmrs APSR_nzcv, fpscr; vabs.f32 s22, s20\n",
            "it mi; vnegmi.f32 s23, s23\n",
            "vadd.f32 s22, s22, s24; vadd.f32 s22, s22, s16; vdiv.f32 s23, s23, s22\n",
            // Cosine in s24, sine in s25.
            "vmov.f32 s24, s15; vmla.f32 s24, s23, s23; vsqrt.f32 s24, s24\n",
            "vdiv.f32 s24, s15, s24; vmul.f32 s25, s23, s24\n",
            "vmul.f32 s26, s23, ", $off, "; vmov.f32 ", $off, ", s17\n",
            "vsub.f32 ", $a, ", ", $a, ", s26; vadd.f32 ", $b, ", ", $b, ", s26\n",
            turned!($p $q), turned!($x0 $y0), turned!($x1 $y1), turned!($x2 $y2),
        )
    };
}

/// Turns two numbers.
macro_rules! turned {
    ($x:literal $y:literal) => {
        concat!(
            "vmul.f32 s27, s25, ",
            $x,
            "; vmul.f32 ",
            $x,
            ", s24, ",
            $x,
            "\n",
            "vmls.f32 ",
            $x,
            ", s25, ",
            $y,
            "; vmul.f32 ",
            $y,
            ", s24, ",
            $y,
            "\n",
            "vadd.f32 ",
            $y,
            ", s27, ",
            $y,
            "\n",
        )
    };
}

/// Eigenvalues and eigenvectors of the matrix with these elements, xx, yy, zz, xy, xz and yz, after some rounds,
/// at least one.
pub(super) fn rotated(
    [a, b, c, p, q, r]: [f32; 6],
    rounds: usize,
) -> ([Lane<f32>; 3], Matrix<f32>) {
    let constants = [1.0, f32::MIN_POSITIVE, 0.0];
    let mut all = [a, b, c, p, q, r, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    // SAFETY: the code reads the constants, reads and writes the numbers, and does not touch the stack.
    unsafe {
        asm!(
            "vldmia {constants}, {{s15-s17}}; vldmia {all}, {{s0-s14}}",
            "2:",
            rotation!("s0" "s1" "s3", "s4" "s5", "s6" "s9", "s7" "s10", "s8" "s11"),
            rotation!("s0" "s2" "s4", "s3" "s5", "s6" "s12", "s7" "s13", "s8" "s14"),
            rotation!("s1" "s2" "s5", "s3" "s4", "s9" "s12", "s10" "s13", "s11" "s14"),
            "subs {rounds}, {rounds}, #1; bne 2b",
            "vstmia {all}, {{s0-s14}}",
            constants = in(reg) constants.as_ptr(),
            all = in(reg) all.as_mut_ptr(),
            rounds = inout(reg) rounds => _,
            out("s0") _, out("s1") _, out("s2") _, out("s3") _, out("s4") _, out("s5") _,
            out("s6") _, out("s7") _, out("s8") _, out("s9") _, out("s10") _, out("s11") _,
            out("s12") _, out("s13") _, out("s14") _, out("s15") _, out("s16") _, out("s17") _,
            out("s20") _, out("s22") _, out("s23") _, out("s24") _, out("s25") _, out("s26") _,
            out("s27") _,
            options(nostack),
        );
    }
    let [a, b, c, .., d, e, f, g, h, i, j, k, l] = all.map(Lane);
    ([a, b, c], [[d, e, f], [g, h, i], [j, k, l]])
}
