//! When a polynomial is Hurwitz (all its roots in the left half plane), and when every mixture of two
//! is.
//!
//! Let p₀ + p₁ w + … + pₙ wⁿ be a polynomial of degree five. It is Hurwitz exactly when all pₖ and the Hurwitz
//! determinants of even order are positive (Liénard and Chipart, 1914):
//!
//! Δ₂ = p₄ p₃ − p₅ p₂, Δ₄ = Δ₂ (p₂ p₁ − p₃ p₀) − (p₄ p₁ − p₅ p₀)²
//!
//! With p₅ = 0 these are p₄ Δ₁ and p₄ Δ₃ of degree four, so that one formula serves both.
//!
//! Consider a path from one Hurwitz polynomial to another. A root can leave the half plane through zero, where p₀ = 0,
//! or through infinity, where pₙ = 0. A pair can leave through the imaginary axis, where Δₙ₋₁ = 0 (Orlando, 1911). For
//! the mixtures s u + t v, s and t not negative, pₖ is linear in s and t. The determinant Δₙ₋₁ is a form of the fourth
//! degree in them. If u is Hurwitz and all coefficients of these are positive, no mixture loses a root. All mixtures
//! are then Hurwitz, and none has to be tested. The coefficients are, up to binomials, those of Bernstein's basis.

/// The largest degree.
pub(super) const DEGREE: usize = 5;

/// A polynomial in w of degree four or five.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Polynomial {
    /// Lowest power first; the last is zero for degree four.
    pub(super) coefficients: [f64; DEGREE + 1],
    /// Its degree.
    pub(super) degree: usize,
}

impl Polynomial {
    /// True if all its roots lie in the left half plane.
    pub(super) fn is_hurwitz(&self) -> bool {
        let [p0, p1, p2, p3, p4, p5] = self.coefficients;
        let second = p4 * p3 - p5 * p2;
        let cross = p4 * p1 - p5 * p0;
        self.has_positive_coefficients()
            && second > 0.0
            && second * (p2 * p1 - p3 * p0) > cross * cross
    }

    /// True if every convex combination with another polynomial of the same degree is proved to be Hurwitz, the other
    /// included. This polynomial must be Hurwitz. False proves nothing.
    pub(super) fn stays_hurwitz_up_to(&self, other: &Self) -> bool {
        if !other.has_positive_coefficients() {
            return false;
        }
        let (u, v) = (&self.coefficients, &other.coefficients);
        // (s uᵢ + t vᵢ)(s uⱼ + t vⱼ) − (s uₖ + t vₖ)(s uₗ + t vₗ): coefficients of s², s t, t².
        let minor = |[i, j]: [usize; 2], [k, l]: [usize; 2]| {
            [
                u[i] * u[j] - u[k] * u[l],
                (u[i] * v[j] + v[i] * u[j]) - (u[k] * v[l] + v[k] * u[l]),
                v[i] * v[j] - v[k] * v[l],
            ]
        };
        let [x0, x1, x2] = minor([4, 3], [5, 2]);
        let [y0, y1, y2] = minor([2, 1], [3, 0]);
        let [z0, z1, z2] = minor([4, 1], [5, 0]);
        x0 * y0 > z0 * z0
            && x2 * y2 > z2 * z2
            && x0 * y1 + x1 * y0 > 2.0 * z0 * z1
            && x1 * y2 + x2 * y1 > 2.0 * z1 * z2
            && x0 * y2 + x1 * y1 + x2 * y0 > 2.0 * z0 * z2 + z1 * z1
    }

    fn has_positive_coefficients(&self) -> bool {
        self.coefficients
            .iter()
            .take(self.degree + 1)
            .all(|&coefficient| coefficient > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A factor w² + damping w + stiffness.
    type Pair = [f64; 2];

    /// A polynomial from a real root and two pairs; without the root it is of degree four.
    fn with_roots(root: Option<f64>, pairs: [Pair; 2]) -> Polynomial {
        let mut coefficients = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let mut multiply = |factor: [f64; 3]| {
            let old = coefficients;
            coefficients = core::array::from_fn(|k| {
                let of = |i: usize| k.checked_sub(i).map_or(0.0, |j| factor[i] * old[j]);
                of(0) + of(1) + of(2)
            });
        };
        for [damping, stiffness] in pairs {
            multiply([stiffness, damping, 1.0]);
        }
        if let Some(root) = root {
            multiply([-root, 1.0, 0.0]);
        }
        Polynomial {
            coefficients,
            degree: if root.is_some() { 5 } else { 4 },
        }
    }

    fn mixture(u: &Polynomial, v: &Polynomial, part: f64) -> Polynomial {
        Polynomial {
            coefficients: core::array::from_fn(|k| {
                (1.0 - part) * u.coefficients[k] + part * v.coefficients[k]
            }),
            degree: u.degree,
        }
    }

    fn pair() -> impl Strategy<Value = Pair> {
        [-1.0_f64..3.0, 0.01_f64..4.0]
    }

    fn polynomial() -> impl Strategy<Value = (Option<f64>, [Pair; 2])> {
        (proptest::option::of(-3.0_f64..0.5), [pair(), pair()])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        /// The roots are known, so the verdict is.
        #[test]
        fn hurwitz_says_where_the_roots_are((root, pairs) in polynomial()) {
            let dampings = pairs.map(|[damping, _]| damping);
            let all = [dampings[0], dampings[1], -root.unwrap_or(-1.0)];
            prop_assume!(all.iter().all(|value: &f64| value.abs() > 1e-6));
            let expected = all.iter().all(|&value| value > 0.0);
            prop_assert_eq!(with_roots(root, pairs).is_hurwitz(), expected);
        }

        /// A proof for all mixtures of two polynomials holds for each of them.
        #[test]
        fn a_proof_holds_for_every_mixture(
            one in [0.02_f64..3.0, 0.02_f64..3.0],
            other in [-0.1_f64..3.0, 0.02_f64..3.0],
            stiffness in [0.01_f64..4.0, 0.01_f64..4.0, 0.01_f64..4.0, 0.01_f64..4.0],
            roots in proptest::option::of([0.01_f64..3.0, -0.5_f64..3.0]),
        ) {
            let root = |i: usize| roots.map(|roots| -roots[i]);
            let u = with_roots(root(0), [[one[0], stiffness[0]], [one[1], stiffness[1]]]);
            let v = with_roots(root(1), [[other[0], stiffness[2]], [other[1], stiffness[3]]]);
            prop_assert!(u.is_hurwitz());
            if u.stays_hurwitz_up_to(&v) {
                for i in 0..=100 {
                    prop_assert!(mixture(&u, &v, f64::from(i) / 100.0).is_hurwitz());
                }
            }
        }
    }

    /// Two Hurwitz polynomials with one between them that is not.
    #[test]
    fn an_island_between_two_ends_is_no_proof() {
        let u = with_roots(None, [[0.1, 1.0], [0.1, 0.1]]);
        let v = with_roots(None, [[0.1, 8.0], [4.0, 0.1]]);
        assert!(u.is_hurwitz() && v.is_hurwitz());
        let island = (0..=100).any(|i| !mixture(&u, &v, f64::from(i) / 100.0).is_hurwitz());
        assert!(island);
        assert!(!u.stays_hurwitz_up_to(&v));
    }

    /// Otherwise the proof would be sound and of no use.
    #[test]
    fn polynomials_that_are_alike_are_proved() {
        let u = with_roots(Some(-0.5), [[0.3, 1.0], [1.0, 2.0]]);
        let v = with_roots(Some(-0.6), [[0.4, 1.5], [0.9, 2.0]]);
        assert!(u.stays_hurwitz_up_to(&u) && u.stays_hurwitz_up_to(&v));
    }

    /// A leading coefficient of zero is a root at infinity, not a lower degree.
    #[test]
    fn a_root_at_infinity_is_not_in_the_half_plane() {
        let mut p = with_roots(None, [[1.0, 1.0], [1.0, 2.0]]);
        assert!(p.is_hurwitz());
        p.degree = 5;
        assert!(!p.is_hurwitz());
    }
}
