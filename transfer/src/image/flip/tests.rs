use super::*;
use proptest::prelude::*;

fn uniform(width: usize, height: usize, pixel: [u8; 3]) -> Picture {
    Picture { width, height, pixels: vec![pixel; width * height] }
}

fn noise(width: usize, height: usize, seed: usize) -> Picture {
    let pixel = |i: usize| [0, 1, 2].map(|c| (((i * 7919 + c * 104_729 + seed * 31) * 2_654_435_761) >> 13) as u8);
    Picture { width, height, pixels: (0..width * height).map(pixel).collect() }
}

/// Every pixel `share` of the way to another picture.
fn towards(picture: &Picture, other: &Picture, share: f64) -> Picture {
    let mix = |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
    let pairs = picture.pixels.iter().zip(&other.pixels);
    let pixels = pairs.map(|(p, q)| [0, 1, 2].map(|c| mix(p[c], q[c]))).collect();
    Picture { pixels, ..*picture }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn differences_are_symmetric_from_0_to_1_and_of_equal_pictures_0(
        width in 1..40usize, height in 1..30usize, a in 0..99usize, b in 0..99usize,
    ) {
        let [p, q] = [a, b].map(|seed| noise(width, height, seed));
        let flip = p.flip(&q).unwrap();
        prop_assert!(flip.map.iter().all(|e| (0.0..=1.0).contains(e)));
        prop_assert_eq!(&flip, &q.flip(&p).unwrap());
        prop_assert_eq!(p.flip(&p).unwrap().map, vec![0.0; width * height]);
        prop_assert_eq!(a == b, flip.mean == 0.0);
    }
}

/// The paper's steps for pictures of one colour each, which filters leave as they are and which have no features: HyAB to the power of
/// 0.7, and its place between 0, the knee and the largest.
fn of_uniform(hyab: f64) -> f64 {
    // Lightness and Hunt-adjusted a and b of green and blue, of tables: (87.735, -86.183, 83.180), (32.297, 79.188, -107.860).
    let green = [87.735, -0.87735 * 86.183, 0.87735 * 83.180];
    let blue = [32.297, 0.32297 * 79.188, -0.32297 * 107.860];
    let largest: f64 = green[0] - blue[0] + f64::hypot(green[1] - blue[1], green[2] - blue[2]);
    let (compressed, largest) = (hyab.powf(0.7), largest.powf(0.7));
    let knee = 0.4 * largest;
    match compressed < knee {
        true => 0.95 * compressed / knee,
        false => 0.95 + 0.05 * (compressed - knee) / (largest - knee),
    }
}

#[test]
fn pictures_of_one_colour_differ_as_the_definition_says() {
    let grey = |code: u8| uniform(30, 20, [code; 3]);
    // L* of grey with the sRGB code 119 is 50.03; of black 0, of white 100.
    let known = [
        (grey(0), grey(255), of_uniform(100.0)),
        (grey(119), grey(255), of_uniform(49.97)),
        (grey(0), grey(119), of_uniform(50.03)),
        (uniform(30, 20, [0, 255, 0]), uniform(30, 20, [0, 0, 255]), 1.0),
    ];
    for (p, q, expected) in known {
        let flip = p.flip(&q).unwrap();
        assert!((flip.mean - expected).abs() < 2e-4, "{} {expected}", flip.mean);
        assert!(flip.map.iter().all(|&e| (f64::from(e) - expected).abs() < 2e-4), "filters keep a constant");
    }
}

#[test]
fn a_larger_distortion_is_a_larger_difference() {
    let (picture, other) = (noise(48, 40, 1), uniform(48, 40, [200, 30, 90]));
    let means: Vec<f64> =
        [0.0, 0.1, 0.3, 0.6, 1.0].map(|share| towards(&picture, &other, share).flip(&picture).unwrap().mean).into();
    assert!(means[0] == 0.0 && means.windows(2).all(|pair| pair[0] < pair[1]), "{means:?}");
}

#[test]
fn from_afar_fine_noise_is_hardly_seen_and_a_displaced_edge_is_seen_more_than_its_colour_alone() {
    let grey = uniform(64, 64, [128; 3]);
    let at = |picture: &Picture, distance: f64| {
        let [a, b] = [picture, &grey].map(|p| Perceived::new(p, distance).unwrap());
        a.flip(&b).unwrap().mean
    };
    let rough = towards(&grey, &noise(64, 64, 5), 0.5);
    assert!(at(&rough, 200.0) < 0.5 * at(&rough, 20.0), "{} {}", at(&rough, 200.0), at(&rough, 20.0));
    // A step of 16 codes against the grey: at its edge there is a feature that the grey lacks.
    let mut step = grey.clone();
    (0..64 * 64).filter(|i| i % 64 >= 32).for_each(|i| step.pixels[i] = [144; 3]);
    let map = step.flip(&grey).unwrap().map;
    assert!(map[32 * 64 + 33] > 1.2 * map[32 * 64 + 60], "{} {}", map[32 * 64 + 33], map[32 * 64 + 60]);
}

#[test]
fn means_are_over_covered_pixels_and_maps_go_from_black_to_pale_yellow() {
    let flip = Flip { width: 3, height: 1, map: vec![0.0, 0.5, 1.0], mean: 0.5 };
    assert_eq!(flip.mean_over(&[0.99, 1.0, 1.0]).unwrap(), 0.75);
    assert!(flip.mean_over(&[0.0; 3]).is_err() && flip.mean_over(&[1.0; 2]).is_err());
    let picture = flip.picture();
    assert_eq!((picture.pixels[0], picture.pixels[2]), ([0, 0, 4], [252, 253, 191]));
}

#[test]
fn the_map_is_the_same_on_any_number_of_threads() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| noise(70, 50, 1).flip(&noise(70, 50, 2)).unwrap())
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn pictures_that_do_not_fit_and_distances_without_sense_are_refused() {
    let picture = uniform(4, 3, [1; 3]);
    assert!(picture.flip(&uniform(3, 4, [1; 3])).unwrap_err().to_string().contains("width"));
    assert!(picture.flip(&uniform(0, 0, [1; 3])).unwrap_err().to_string().contains("at least one pixel"));
    assert!(Perceived::new(&Picture { width: 5, ..picture.clone() }, 67.0).is_err());
    for distance in [0.0, -1.0, f64::NAN, 1e9] {
        assert!(Perceived::new(&picture, distance).unwrap_err().to_string().contains("pixels per degree"));
    }
}
