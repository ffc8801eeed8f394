//! Forces: each file holds one element's formula as a pure function of values.

pub mod air;
pub mod external;
pub mod gust;
pub mod hinge;
pub mod spring;
