use super::Number;
use core::ops::{Add, Div, Mul, Sub};

/// A complex number, for frequency responses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Complex<N = f64> {
    /// Real part.
    pub re: N,
    /// Imaginary part.
    pub im: N,
}

impl Complex {
    /// e^z.
    #[must_use]
    pub fn exponential(self) -> Self {
        let (im, re) = libm::sincos(self.im);
        Self { re, im }.scaled(libm::exp(self.re))
    }
}

impl<N: Number> Complex<N> {
    /// A number of a real and an imaginary part.
    #[must_use]
    pub const fn new(re: N, im: N) -> Self {
        Self { re, im }
    }

    /// 0.
    pub const ZERO: Self = Self::new(N::ZERO, N::ZERO);
    /// 1.
    pub const ONE: Self = Self::new(N::ONE, N::ZERO);

    /// In another format.
    #[must_use]
    pub fn to<M: Number>(self) -> Complex<M> {
        Complex::new(M::from_f64(self.re.to_f64()), M::from_f64(self.im.to_f64()))
    }

    /// The conjugate.
    #[must_use]
    pub fn conjugate(self) -> Self {
        Self {
            im: -self.im,
            ..self
        }
    }

    /// |z|².
    #[must_use]
    pub fn power(self) -> N {
        self.re * self.re + self.im * self.im
    }

    /// The product with a real number.
    #[must_use]
    pub fn scaled(self, factor: N) -> Self {
        Self::new(factor * self.re, factor * self.im)
    }

    /// The power with a whole exponent.
    #[must_use]
    pub fn raised(self, exponent: u32) -> Self {
        let (mut result, mut square, mut left) = (Self::ONE, self, exponent);
        while left > 0 {
            if left % 2 == 1 {
                result = result * square;
            }
            square = square * square;
            left /= 2;
        }
        result
    }
}

impl<N: Number> Mul for Complex<N> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self::new(
            self.re * other.re - self.im * other.im,
            self.re * other.im + self.im * other.re,
        )
    }
}

impl<N: Number> Div for Complex<N> {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let product = self.mul(other.conjugate());
        product.scaled(other.power().reciprocal())
    }
}

impl<N: Number> Sub for Complex<N> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::new(self.re - other.re, self.im - other.im)
    }
}

impl<N: Number> Add for Complex<N> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::new(self.re + other.re, self.im + other.im)
    }
}

impl<N: Number> Add<N> for Complex<N> {
    type Output = Self;

    fn add(self, real: N) -> Self {
        Self {
            re: self.re + real,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Complex;

    #[test]
    fn a_power_is_repeated_multiplication() {
        let z: Complex = Complex { re: 0.8, im: -0.6 };
        let mut product = Complex::ONE;
        for exponent in 0..40 {
            let off = z.raised(exponent) - product;
            assert!(off.power() < 1e-28, "{exponent}");
            product = product * z;
        }
        assert!(((z * z.conjugate()).re - z.power()).abs() < 1e-15);
        assert!((z * z / z - z).power() < 1e-30);
    }
}
