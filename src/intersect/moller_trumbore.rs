//! The ray–triangle test.
