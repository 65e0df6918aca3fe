//! Units: SI across FMI and inside, display units for people.

/// An SI unit with the unit people read: `displayed = factor * SI`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Symbol of the SI unit.
    pub symbol: &'static str,
    /// Exponents of kg, m and s.
    pub exponents: (i8, i8, i8),
    /// Exponent of rad.
    pub radians: i8,
    /// Usual size of what is measured in it (SI): what comparers and solvers scale with.
    pub nominal: f64,
    /// Symbol of the display unit; may equal `symbol`.
    pub display: &'static str,
    /// Value in display units of 1 SI unit.
    pub factor: f64,
}

const fn unit(
    symbol: &'static str,
    exponents: (i8, i8, i8),
    display: &'static str,
    factor: f64,
    nominal: f64,
) -> Unit {
    Unit { symbol, exponents, radians: 0, nominal, display, factor }
}

/// A pure number.
pub const ONE: Unit = unit("1", (0, 0, 0), "1", 1.0, 1.0);
/// Angle.
pub const RADIAN: Unit =
    Unit { radians: 1, ..unit("rad", (0, 0, 0), "deg", 180.0 / std::f64::consts::PI, 1.0) };
/// Length.
pub const METRE: Unit = unit("m", (0, 1, 0), "mm", 1e3, 1e-3);
/// Velocity.
pub const METRE_PER_SECOND: Unit = unit("m/s", (0, 1, -1), "mm/s", 1e3, 1e-3);
/// Permeability.
pub const SQUARE_METRE: Unit = unit("m^2", (0, 2, 0), "mm^2", 1e6, 1e-15);
/// Volume.
pub const CUBIC_METRE: Unit = unit("m^3", (0, 3, 0), "mm^3", 1e9, 1e-9);
/// Time.
pub const SECOND: Unit = unit("s", (0, 0, 1), "s", 1.0, 1.0);
/// Force.
pub const NEWTON: Unit = unit("N", (1, 1, -2), "mN", 1e3, 1e-2);
/// Stress and modulus.
pub const PASCAL: Unit = unit("Pa", (1, -1, -2), "Pa", 1.0, 1e3);
/// Viscosity.
pub const PASCAL_SECOND: Unit = unit("Pa s", (1, -1, -1), "Pa s", 1.0, 1e2);
/// Power.
pub const WATT: Unit = unit("W", (1, 2, -3), "uW", 1e6, 1e-5);
/// Change of a force with a modulus.
pub const NEWTON_PER_PASCAL: Unit = unit("N/Pa", (0, 2, 0), "mN/Pa", 1e3, 1e-5);
/// Change of a force with a viscosity.
pub const NEWTON_PER_PASCAL_SECOND: Unit = unit("N/(Pa s)", (0, 2, -1), "mN/(Pa s)", 1e3, 1e-4);
/// Change of a force with a permeability.
pub const NEWTON_PER_SQUARE_METRE: Unit = unit("N/m^2", (1, -1, -2), "mN/mm^2", 1e-3, 1e13);
/// Reciprocal of a stress.
pub const PER_PASCAL: Unit = unit("1/Pa", (-1, 1, 2), "1/kPa", 1e3, 1e-3);
/// Relative rate.
pub const PER_SECOND: Unit = unit("1/s", (0, 0, -1), "1/s", 1.0, 1e-3);
/// Slip per traction.
pub const METRE_PER_PASCAL: Unit = unit("m/Pa", (-1, 2, 2), "mm/Pa", 1e3, 1e-6);
/// Compliance.
pub const METRE_PER_NEWTON: Unit = unit("m/N", (-1, 0, 2), "mm/mN", 1.0, 1e-3);
/// Rate of a force.
pub const NEWTON_PER_SECOND: Unit = unit("N/s", (1, 1, -3), "mN/s", 1e3, 1e-5);
/// Change of a force with a relative rate.
pub const NEWTON_SECOND: Unit = unit("N s", (1, 1, -1), "mN s", 1e3, 1.0);
/// Change of a force with the reciprocal of a stress.
pub const NEWTON_PASCAL: Unit = unit("N Pa", (2, 0, -4), "mN kPa", 1.0, 1.0);
/// Change of a force with a slip per traction.
pub const NEWTON_PASCAL_PER_METRE: Unit = unit("N Pa/m", (2, -1, -4), "mN Pa/mm", 1.0, 1e4);
/// Change of a force with a length.
pub const NEWTON_PER_METRE: Unit = unit("N/m", (1, 0, -2), "mN/mm", 1.0, 10.0);
/// Change of a force with a compliance.
pub const SQUARE_NEWTON_PER_METRE: Unit = unit("N^2/m", (2, 1, -4), "mN^2/mm", 1e3, 0.1);
/// Energy.
pub const JOULE: Unit = unit("J", (1, 2, -2), "uJ", 1e6, 1e-5);

/// Every unit that the variable table may use.
pub const ALL: [&Unit; 25] = [
    &ONE,
    &RADIAN,
    &METRE,
    &METRE_PER_SECOND,
    &SQUARE_METRE,
    &CUBIC_METRE,
    &SECOND,
    &NEWTON,
    &PASCAL,
    &PASCAL_SECOND,
    &NEWTON_PER_PASCAL,
    &NEWTON_PER_PASCAL_SECOND,
    &NEWTON_PER_SQUARE_METRE,
    &PER_PASCAL,
    &PER_SECOND,
    &METRE_PER_PASCAL,
    &METRE_PER_NEWTON,
    &NEWTON_PER_SECOND,
    &NEWTON_SECOND,
    &NEWTON_PASCAL,
    &NEWTON_PASCAL_PER_METRE,
    &NEWTON_PER_METRE,
    &SQUARE_NEWTON_PER_METRE,
    &WATT,
    &JOULE,
];
