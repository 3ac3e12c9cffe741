//! Vectors of numbers in lanes: a point, a direction or a colour in each lane.
//!
//! `Vec3<f32>` is one vector. glam is for what is set up once, these are for what runs for each path; [`From`]
//! converts between `Vec3<f32>` and glam's.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::real::{Double, Float, Lanes, Lift, Mask, Real};

/// The sum, from the first on.
#[inline(always)]
fn sum<R: Float, const N: usize>(terms: [R; N]) -> R {
    let mut sum = terms[0];
    for term in &terms[1..] {
        sum += *term;
    }
    sum
}

macro_rules! vector {
    ($(#[$doc:meta])* $Vector:ident: $($component:ident),*; $count:literal of them, first $first:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $Vector<R = f32> {
            $(
                #[doc = concat!("Component ", stringify!($component), ".")]
                pub $component: R,
            )*
        }

        impl<R> $Vector<R> {
            /// From its components.
            #[inline(always)]
            #[must_use]
            pub const fn new($($component: R),*) -> Self {
                Self { $($component),* }
            }

            /// Its components.
            #[inline(always)]
            #[must_use]
            pub fn to_array(self) -> [R; $count] {
                [$(self.$component),*]
            }

            /// Something of each component.
            #[inline(always)]
            #[must_use]
            pub fn map<T>(self, mut of: impl FnMut(R) -> T) -> $Vector<T> {
                $Vector { $($component: of(self.$component)),* }
            }
        }

        impl<R> From<[R; $count]> for $Vector<R> {
            #[inline(always)]
            fn from([$($component),*]: [R; $count]) -> Self {
                Self { $($component),* }
            }
        }

        impl<R: Float> $Vector<R> {
            /// Of each component its magnitude.
            #[inline(always)]
            #[must_use]
            pub fn abs(self) -> Self {
                self.map(R::abs)
            }

            /// The sum of the components.
            #[inline(always)]
            #[must_use]
            pub fn element_sum(self) -> R {
                sum([$(self.$component),*])
            }

            /// The components' products.
            #[inline(always)]
            #[must_use]
            pub fn times(self, other: Self) -> Self {
                Self { $($component: self.$component * other.$component),* }
            }

            /// The components' quotients.
            #[inline(always)]
            #[must_use]
            pub fn over(self, other: Self) -> Self {
                Self { $($component: self.$component / other.$component),* }
            }

            /// The square of the length.
            #[inline(always)]
            #[must_use]
            pub fn length_squared(self) -> R {
                self.dot(self)
            }

            /// The length; 0 or infinite where its square leaves the range of f32.
            #[inline(always)]
            #[must_use]
            pub fn length(self) -> R {
                self.length_squared().sqrt()
            }

            /// The unit vector of the same direction; not finite, or not of length 1, where the square of the length
            /// leaves the range of f32.
            #[inline(always)]
            #[must_use]
            pub fn normalize(self) -> Self {
                self / self.length()
            }

        }

        impl<D: Double> $Vector<D> {
            /// The nearest vector of less precision.
            #[inline(always)]
            #[must_use]
            pub fn narrow(self) -> $Vector<D::Real> {
                self.map(D::narrow)
            }
        }

        impl<R: Real> $Vector<R> {
            /// The same vector in twice the precision.
            #[inline(always)]
            #[must_use]
            pub fn widen(self) -> $Vector<R::Double> {
                self.map(R::widen)
            }

            /// The unit vector of the same direction, and whether there is one: whether the inverse of the length is
            /// finite and above 0.
            #[inline(always)]
            #[must_use]
            pub fn try_normalize(self) -> (Self, R::Mask) {
                let inverse = self.length().recip();
                (self * inverse, inverse.gt(0.0) & inverse.lt(f32::INFINITY))
            }

            /// The vector where the mask is set, 0 elsewhere.
            #[inline(always)]
            #[must_use]
            pub fn only_where(self, mask: R::Mask) -> Self {
                self.map(|component| R::select(mask, component, 0.0))
            }

            /// `self` at `t = 0` and `end` at `t = 1`, both exactly.
            #[inline(always)]
            #[must_use]
            pub fn lerp(self, end: Self, t: R) -> Self {
                self * t.one_minus() + end * t
            }
        }

        impl<R: Float> Lanes for $Vector<R> {
            type Lane = $Vector<R::Lane>;
            type Mask = R::Mask;
            type Token = R::Token;
            type Each<T: Copy + Debug> = R::Each<T>;

            const LANES: usize = R::LANES;

            #[inline(always)]
            fn each<T: Copy + Debug>(of: impl FnMut(usize) -> T) -> R::Each<T> {
                R::each(of)
            }

            #[inline(always)]
            fn token(self) -> R::Token {
                self.$first.token()
            }

            #[inline(always)]
            fn splat(token: R::Token, value: Self::Lane) -> Self {
                Self { $($component: R::splat(token, value.$component)),* }
            }

            #[inline(always)]
            fn from_fn(token: R::Token, value: impl FnMut(usize) -> Self::Lane) -> Self {
                Self::load(token, R::each(value).as_ref())
            }

            #[inline(always)]
            fn lane(self, i: usize) -> Self::Lane {
                $Vector { $($component: self.$component.lane(i)),* }
            }

            #[inline(always)]
            fn load(token: R::Token, values: &[Self::Lane]) -> Self {
                assert_eq!(values.len(), R::LANES);
                Self { $($component: R::from_fn(token, |i| values[i].$component)),* }
            }

            #[inline(always)]
            fn store(self, values: &mut [Self::Lane]) {
                assert_eq!(values.len(), R::LANES);
                for (i, value) in values.iter_mut().enumerate() {
                    *value = self.lane(i);
                }
            }

            #[inline(always)]
            fn compress(self, mask: R::Mask) -> Self {
                self.map(|component| component.compress(mask))
            }

            #[inline(always)]
            fn select(mask: R::Mask, yes: impl Lift<Self>, no: impl Lift<Self>) -> Self {
                let (yes, no) = (yes.lift(mask.token()), no.lift(mask.token()));
                Self { $($component: R::select(mask, yes.$component, no.$component)),* }
            }
        }

        impl<R: Float> Lift<Self> for $Vector<R> {
            #[inline(always)]
            fn lift(self, _: R::Token) -> Self {
                self
            }
        }

        impl<R: Float> Neg for $Vector<R> {
            type Output = Self;

            #[inline(always)]
            fn neg(self) -> Self {
                Self { $($component: -self.$component),* }
            }
        }

        impl<R: Float> Add for $Vector<R> {
            type Output = Self;

            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self { $($component: self.$component + other.$component),* }
            }
        }

        impl<R: Float> Sub for $Vector<R> {
            type Output = Self;

            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self { $($component: self.$component - other.$component),* }
            }
        }

        impl<R: Float, T: Lift<R>> Mul<T> for $Vector<R> {
            type Output = Self;

            #[inline(always)]
            fn mul(self, factor: T) -> Self {
                let factor = factor.lift(self.token());
                Self { $($component: self.$component * factor),* }
            }
        }

        impl<R: Float, T: Lift<R>> Div<T> for $Vector<R> {
            type Output = Self;

            #[inline(always)]
            fn div(self, divisor: T) -> Self {
                let divisor = divisor.lift(self.token());
                Self { $($component: self.$component / divisor),* }
            }
        }
    };
}

vector! {
    /// A point or a vector of the plane in each lane.
    Vec2: x, y; 2 of them, first x
}

vector! {
    /// A point or a vector of space in each lane.
    Vec3: x, y, z; 3 of them, first x
}

macro_rules! as_in_glam {
    ($Vector:ident, $($component:ident),*: $Glam:ident of $Lane:ty) => {
        impl From<glam::$Glam> for $Vector<$Lane> {
            #[inline(always)]
            fn from(v: glam::$Glam) -> Self {
                Self { $($component: v.$component),* }
            }
        }

        impl From<$Vector<$Lane>> for glam::$Glam {
            #[inline(always)]
            fn from(v: $Vector<$Lane>) -> Self {
                Self::new($(v.$component),*)
            }
        }
    };
}

as_in_glam!(Vec2, x, y: Vec2 of f32);
as_in_glam!(Vec2, x, y: DVec2 of f64);
as_in_glam!(Vec3, x, y, z: Vec3 of f32);
as_in_glam!(Vec3, x, y, z: Vec3A of f32);
as_in_glam!(Vec3, x, y, z: DVec3 of f64);

impl<R: Float> Vec2<R> {
    /// The scalar product.
    #[inline(always)]
    #[must_use]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y
    }

    /// The vector of space with the same x and y.
    #[inline(always)]
    #[must_use]
    pub fn extend(self, z: R) -> Vec3<R> {
        Vec3::new(self.x, self.y, z)
    }
}

impl<R: Float> Vec3<R> {
    /// The scalar product.
    #[inline(always)]
    #[must_use]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Of a colour in linear sRGB the [`luminance`](super::luminance).
    #[inline(always)]
    #[must_use]
    pub fn luminance(self) -> R
    where
        R: Real,
    {
        self.x * 0.212_671 + self.y * 0.715_160 + self.z * 0.072_169
    }

    /// The vector product.
    #[inline(always)]
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// Without z.
    #[inline(always)]
    #[must_use]
    pub fn truncate(self) -> Vec2<R> {
        Vec2::new(self.x, self.y)
    }
}
