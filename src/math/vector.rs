//! Vectors of numbers in lanes: a point, a direction or a colour in each lane.
//!
//! `Vec3<f32>` is one vector. glam is for what is set up once, these are for what runs for each path; [`From`]
//! converts between `Vec3<f32>` and glam's.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::real::{Lanes, Lift, Mask, Real};

/// The most lanes that a number has.
const MOST_LANES: usize = 8;

macro_rules! vector {
    ($(#[$doc:meta])* $Vector:ident: $($component:ident),*; first $first:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $Vector<R = f32> {
            $(
                #[doc = concat!("Component ", stringify!($component), ".")]
                pub $component: R,
            )*
        }

        impl<R: Real> $Vector<R> {
            /// From its components.
            #[inline(always)]
            #[must_use]
            pub const fn new($($component: R),*) -> Self {
                Self { $($component),* }
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

            /// The unit vector of the same direction, and whether there is one: whether the inverse of the length is
            /// finite and above 0.
            #[inline(always)]
            #[must_use]
            pub fn try_normalize(self) -> (Self, R::Mask) {
                let inverse = self.length().recip();
                (self * inverse, inverse.gt(0.0) & inverse.lt(f32::INFINITY))
            }

            /// `self` at `t = 0` and `end` at `t = 1`, both exactly.
            #[inline(always)]
            #[must_use]
            pub fn lerp(self, end: Self, t: R) -> Self {
                self * t.one_minus() + end * t
            }
        }

        impl<R: Real> Lanes for $Vector<R> {
            type Lane = $Vector<f32>;
            type Mask = R::Mask;
            type Token = R::Token;

            const LANES: usize = R::LANES;

            #[inline(always)]
            fn token(self) -> R::Token {
                self.$first.token()
            }

            #[inline(always)]
            fn splat(token: R::Token, value: Self::Lane) -> Self {
                Self { $($component: R::splat(token, value.$component)),* }
            }

            #[inline(always)]
            fn from_fn(token: R::Token, mut value: impl FnMut(usize) -> Self::Lane) -> Self {
                let mut values = [Self::Lane::default(); MOST_LANES];
                for i in 0..R::LANES {
                    values[i] = value(i);
                }
                Self::load(token, &values[..R::LANES])
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
            fn select(mask: R::Mask, yes: impl Lift<Self>, no: impl Lift<Self>) -> Self {
                let (yes, no) = (yes.lift(mask.token()), no.lift(mask.token()));
                Self { $($component: R::select(mask, yes.$component, no.$component)),* }
            }
        }

        impl<R: Real> Lift<Self> for $Vector<R> {
            #[inline(always)]
            fn lift(self, _: R::Token) -> Self {
                self
            }
        }

        impl<R: Real> Neg for $Vector<R> {
            type Output = Self;

            #[inline(always)]
            fn neg(self) -> Self {
                Self { $($component: -self.$component),* }
            }
        }

        impl<R: Real> Add for $Vector<R> {
            type Output = Self;

            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self { $($component: self.$component + other.$component),* }
            }
        }

        impl<R: Real> Sub for $Vector<R> {
            type Output = Self;

            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self { $($component: self.$component - other.$component),* }
            }
        }

        impl<R: Real, T: Lift<R>> Mul<T> for $Vector<R> {
            type Output = Self;

            #[inline(always)]
            fn mul(self, factor: T) -> Self {
                let factor = factor.lift(self.token());
                Self { $($component: self.$component * factor),* }
            }
        }

        impl<R: Real, T: Lift<R>> Div<T> for $Vector<R> {
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
    Vec2: x, y; first x
}

vector! {
    /// A point or a vector of space in each lane.
    Vec3: x, y, z; first x
}

macro_rules! as_in_glam {
    ($Vector:ident, $($component:ident),*: $Glam:ident) => {
        impl From<glam::$Glam> for $Vector {
            #[inline(always)]
            fn from(v: glam::$Glam) -> Self {
                Self { $($component: v.$component),* }
            }
        }

        impl From<$Vector> for glam::$Glam {
            #[inline(always)]
            fn from(v: $Vector) -> Self {
                Self::new($(v.$component),*)
            }
        }
    };
}

as_in_glam!(Vec2, x, y: Vec2);
as_in_glam!(Vec3, x, y, z: Vec3);
as_in_glam!(Vec3, x, y, z: Vec3A);

impl<R: Real> Vec2<R> {
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

impl<R: Real> Vec3<R> {
    /// The scalar product.
    #[inline(always)]
    #[must_use]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
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
