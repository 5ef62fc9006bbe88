//! Error and condition against the bandwidth of lobes that all have the same.

use crate::charts::curves::{Curves, Dot, Plane};
use crate::error_sums::{of_difference, of_matrix, relative};
use crate::figures::stage::Stage;
use crate::figures::{Drawing, Figure};
use crate::interrupt::Unseen;
use crate::machine::Machine;
use crate::signal::{Signal, Spec};
use crate::table::aligned;
use crate::{compute, number, registry};
use prt_srbf::{Centers, Srbf, SrbfParams};
use prt_transfer::metric::Metric;
use prt_transfer::{Configure, LightBasis, TransferMatrix, Transform};

pub(super) const FIGURE: Figure = Figure { name: "bandwidth", table: None, draw };

const SCENE: &str = "teapot";
const VERTICES: usize = 300;
const BASIS: LightBasis = LightBasis::Cubemap { resolution: 32 };
const CENTERS: usize = 642;
const BANDWIDTHS: [f64; 13] = [1.0, 2.0, 4.0, 8.0, 12.7, 20.0, 40.0, 80.0, 162.9, 300.0, 500.0, 700.0, 1000.0];

/// A way to store coefficients: its name, and what its label has besides centres and bandwidth.
const WAYS: [(&str, &str, &str); 6] = [
    ("lobes, no ridge, f32", ":ridge=0:coordinates=lobes", "dense"),
    ("lobes, no ridge, f16", ":ridge=0:coordinates=lobes", "f16"),
    ("lobes, ridge, f32", ":coordinates=lobes", "dense"),
    ("lobes, ridge, f16", ":coordinates=lobes", "f16"),
    ("orthonormal, ridge, f32", "", "dense"),
    ("orthonormal, ridge, f16", "", "f16"),
];

struct Outcome {
    bandwidth: f64,
    /// Of the Gram matrix: without a ridge, and with the one that was chosen.
    conditions: [f64; 2],
    ridge: f64,
    /// Over the sphere, of each way; the reason where it failed.
    errors: Vec<Result<f64, String>>,
}

fn draw(stage: &Stage) -> anyhow::Result<Drawing> {
    let spec = Spec::new(Signal::Diffuse, BASIS.clone());
    let matrix = compute::precompute(SCENE, Some(VERTICES), &spec, &Unseen)?.matrix;
    let mut outcomes = Vec::new();
    for bandwidth in BANDWIDTHS {
        stage.steps.show(&format!("bandwidth {bandwidth}"));
        outcomes.push(at(stage, &matrix, bandwidth)?);
    }
    let measured = outcomes.iter().any(|o| o.errors.iter().any(Result::is_ok));
    let (text, chart) = (table(&outcomes), chart(&matrix, &outcomes));
    Ok(Drawing {
        text,
        tables: vec![("", csv(&outcomes, &stage.machine)?)],
        chart: Some(chart),
        measured,
        ..Drawing::default()
    })
}

fn at(stage: &Stage, matrix: &TransferMatrix, bandwidth: f64) -> anyhow::Result<Outcome> {
    let params = SrbfParams { centers: Centers::Count(CENTERS), bandwidth: Some(bandwidth), ..SrbfParams::default() };
    let bound = Srbf::new(params)?.bind(matrix.basis())?;
    let gram = bound.gram();
    let added = bound.ridge() * gram.diag().mean().unwrap_or_default();
    let [largest, least] = bound.extremes()?;
    let condition = |ridge: f64| if least + ridge > 0.0 { (largest + ridge) / (least + ridge) } else { f64::INFINITY };
    let metric = Metric::of(matrix)?;
    let whole = of_matrix(matrix, &metric).weighted;
    let error = |(_, options, codec): (&str, &str, &str)| -> Result<f64, String> {
        let label = format!("srbf:bandwidth={bandwidth}{options}+{codec}");
        let method = registry::method(stage.bench.registry, &label).map_err(|e| e.to_string())?;
        let encode = || method.encode(matrix, &Unseen);
        let compressed = stage.bench.pools.everywhere(encode).map_err(|e| e.to_string())?;
        Ok(relative(of_difference(matrix, &compressed, &metric).weighted, whole))
    };
    let errors = WAYS.into_iter().map(error).collect();
    Ok(Outcome { bandwidth, conditions: [condition(0.0), condition(added)], ridge: bound.ridge(), errors })
}

/// Ways of the same storage differ by these.
const KINDS: [&str; 3] = ["lobes, no ridge", "lobes, ridge where needed", "orthonormal coordinates"];

fn chart(matrix: &TransferMatrix, outcomes: &[Outcome]) -> Curves {
    let dot = |o: &Outcome, y: f64| Dot { x: o.bandwidth, y, label: String::new() };
    let error = |way: usize| outcomes.iter().map(|o| dot(o, o.errors[way].clone().unwrap_or(f64::NAN))).collect();
    // Ways alternate between f32 and f16.
    let errors = |storage: usize| (0..KINDS.len()).map(|kind| error(2 * kind + storage)).collect();
    let condition = |ridge: usize| outcomes.iter().map(|o| dot(o, o.conditions[ridge])).collect();
    let plane = |upwards: &str, curves| Plane {
        upwards: upwards.into(),
        across: "bandwidth λ".into(),
        curves,
        references: vec![(162.9, "from spacing".into())],
    };
    Curves {
        title: format!("{CENTERS} lobes: error and condition against bandwidth"),
        subject: format!("{SCENE} · diffuse · {BASIS} · {} samples", matrix.shape().samples),
        remark: None,
        names: KINDS.map(String::from).into(),
        apart: false,
        planes: vec![
            plane("relative squared error, f32", errors(0)),
            plane("relative squared error, f16", errors(1)),
            plane("condition of the Gram matrix", vec![condition(0), condition(1), Vec::new()]),
        ],
    }
}

fn table(outcomes: &[Outcome]) -> String {
    let short_names = ["plain f32", "plain f16", "ridge f32", "ridge f16", "orth. f32", "orth. f16"];
    let titles = ["λ", "condition", "ridge"].into_iter().chain(short_names);
    let short = |value: &f64| if value.is_finite() { number::short(*value) } else { "∞".into() };
    let rows = outcomes.iter().map(|o| {
        let head = [short(&o.bandwidth), short(&o.conditions[0]), short(&o.ridge)];
        head.into_iter().chain(o.errors.iter().map(|e| e.as_ref().map_or_else(|_| "failed".into(), short))).collect()
    });
    format!(
        "Bandwidth (plain, ridge: coefficients of lobes without and with one; orth.: orthonormal coordinates)\n{}",
        aligned(&titles.collect::<Vec<_>>(), rows)
    )
}

fn csv(outcomes: &[Outcome], machine: &Machine) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "bandwidth",
        "way",
        "condition",
        "condition_with_ridge",
        "ridge",
        "error",
        "reason",
        "machine",
    ])?;
    for o in outcomes {
        for (way, error) in WAYS.iter().zip(&o.errors) {
            let (error, reason) = match error {
                Ok(error) => (error.to_string(), String::new()),
                Err(reason) => (String::new(), reason.clone()),
            };
            let figures = [o.conditions[0], o.conditions[1], o.ridge].map(|f| f.to_string());
            let head = [o.bandwidth.to_string(), way.0.into()];
            writer.write_record(head.into_iter().chain(figures).chain([error, reason, machine.line()]))?;
        }
    }
    Ok(writer.into_inner()?)
}
