//! Refractive indices of transparent substances, by name.

/// The index of the substance of that name.
pub(super) fn find(name: &str) -> Option<f64> {
    INDICES.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|&(_, index)| index)
}

/// All names.
pub(super) fn names() -> Vec<&'static str> {
    INDICES.iter().map(|&(name, _)| name).collect()
}

/// At 20 °C and 589 nm, gases at 0 °C: the names and values of Mitsuba 3.9.1, as its dielectrics report
/// them.
static INDICES: [(&str, f64); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000036),
    ("hydrogen", 1.000132),
    ("air", 1.000277),
    ("carbon dioxide", 1.00045),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];
