use super::*;
use ndarray::array;
use proptest::prelude::*;

fn light(kernel: Kernel, bandwidths: [f64; 2]) -> ScatteredLight {
    let lobe = |centre: Direction, bandwidth| Lobe { centre: normalised(centre), bandwidth };
    let lobes = vec![lobe([0.2, -0.7, 0.6], bandwidths[0]), lobe([-0.5, 0.1, -0.8], bandwidths[1])];
    ScatteredLight::new(kernel, lobes, array![[1.0, 0.5, 2.0], [-0.25, 3.0, 0.0]]).unwrap()
}

/// Rodrigues' formula.
fn rotation(axis: Direction, angle: f64) -> [Direction; 3] {
    let [x, y, z] = normalised(axis);
    let (s, c) = angle.sin_cos();
    let t = 1.0 - c;
    [
        [t * x * x + c, t * x * y - s * z, t * x * z + s * y],
        [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
        [t * x * z - s * y, t * y * z + s * x, t * z * z + c],
    ]
}

proptest! {
    #[test]
    fn a_turned_light_shines_from_turned_directions(
        axis in prop::array::uniform3(-1f64..1.0), angle in -3f64..3.0, d in prop::array::uniform3(-1f64..1.0), abel in any::<bool>(),
    ) {
        prop_assume!(dot(axis, axis) > 1e-3 && dot(d, d) > 1e-3);
        let light = if abel { light(Kernel::AbelPoisson, [0.5, 0.9]) } else { light(Kernel::Gaussian, [3.0, 70.0]) };
        let (r, d) = (rotation(axis, angle), normalised(d));
        let turned = light.rotated(r).unwrap();
        let back = |v: Direction| r.map(|row| dot(row, v));
        let (before, after) = (light.radiance(d), turned.radiance(back(d)));
        prop_assert!(before.iter().zip(&after).all(|(a, b)| (a - b).abs() < 1e-9 * (1.0 + a.abs())), "{before:?} {after:?}");
        prop_assert_eq!(light.flux(), turned.flux());
    }
}

#[test]
fn flux_is_the_sum_over_texels() {
    let light = light(Kernel::Gaussian, [3.0, 20.0]);
    let basis = LightBasis::Cubemap { resolution: 64 };
    let texels = light.texels(&basis).unwrap();
    for (channel, flux) in light.flux().into_iter().enumerate() {
        let sum: f64 =
            texels.column(channel).iter().zip(basis.solid_angles().unwrap()).map(|(l, a)| f64::from(*l) * a).sum();
        assert!((sum / flux - 1.0).abs() < 1e-4, "{sum} {flux}");
    }
}

#[test]
fn what_is_no_light_is_refused_with_its_place() {
    let lobe = Lobe { centre: [0.0, 0.0, 1.0], bandwidth: 5.0 };
    let refused = |lobe: Lobe, coefficient: f64, rows: usize| {
        let coefficients = Array2::from_elem((rows, 1), coefficient);
        ScatteredLight::new(Kernel::Gaussian, vec![lobe], coefficients).unwrap_err().to_string()
    };
    assert!(refused(lobe, f64::NAN, 1).contains("NaN"));
    assert!(refused(lobe, 1.0, 2).contains("expected 1, found 2"));
    for bandwidth in [f64::NAN, 0.0, -1.0, 1e9] {
        assert!(refused(Lobe { bandwidth, ..lobe }, 1.0, 1).contains("bandwidth from 0.01 to 100000"));
    }
    for centre in [[0.0; 3], [f64::NAN, 0.0, 1.0], [0.0, 0.0, 1.1]] {
        assert!(refused(Lobe { centre, ..lobe }, 1.0, 1).contains("unit vector"));
    }
    let light = light(Kernel::Gaussian, [1.0, 1.0]);
    assert!(light.rotated([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]).is_err());
    assert!(light.texels(&LightBasis::Plain { lights: 3 }).is_err());
}
