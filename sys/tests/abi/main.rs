//! The declarations agree with the library that is linked, and the shim does what `shim.h` says.
//! Every test must pass against Embree 3.13 and 4 alike.

#![allow(unsafe_code, reason = "there is nothing else to call")]

mod device;
mod filter;
mod scene;
mod triangle;
mod user_geometry;
