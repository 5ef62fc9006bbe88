//! What a matrix is multiplied by multiplies what comes back.

use prt_harness::registry::registry;
use prt_tests::*;

/// Everything does what it does in units of the largest element.
#[test]
fn a_power_of_two_passes_through_every_method() {
    let registry = registry();
    for label in labels(&registry) {
        for case in harmless() {
            let Some((_, plain)) = encode_where_defined(&registry, &label, &case) else { continue };
            let plain = decoded(&plain);
            for exponent in [-80, 80] {
                let factor = 2f32.powi(exponent);
                let scaled = Case { name: case.name, matrix: with(&case.matrix, elements(&case.matrix) * factor) };
                let compressed = encode_where_defined(&registry, &label, &scaled);
                let name = || format!("{label} on {} by 2^{exponent}", case.name);
                let (_, compressed) = compressed.unwrap_or_else(|| panic!("{} is refused", name()));
                let distance = far((decoded(&compressed) / factor).view(), plain.view());
                assert!(distance < 1e-5, "{}: {distance:e}", name());
            }
        }
    }
}
