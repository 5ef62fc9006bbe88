//! The models of a family on a matrix: every value of each parameter with every value of the others.

use super::surrogate::Place;
use crate::registry::families::{Axis, Extent, Family, Start};
use prt_transfer::{Label, Shape, Stage};

/// How much the numbers in which a model is stored matter to its error.
const STORED: f64 = 0.02;

/// Places along each axis.
pub(super) type Point = Vec<usize>;

/// A grid of labels.
pub(super) struct Grid {
    base: Label,
    axes: Vec<Values>,
}

/// An axis with the values that a matrix has a use for.
struct Values {
    axis: &'static Axis,
    values: Vec<&'static str>,
    places: Vec<Place>,
}

impl Grid {
    /// The grid of a family whose labels begin with `base`, which may fix parameters of its axes.
    pub(super) fn new(family: &Family, base: Label, shape: Shape) -> Grid {
        let own = family.base.parse::<Label>().ok();
        let own = |parameter: &str| own.as_ref().and_then(|own| value(own, parameter));
        // What the family's own label says of an axis is the point of a bench, not a wish.
        let free = |axis: &&'static Axis| {
            axis.parameters.iter().all(|p| value(&base, p).is_none_or(|value| own(p) == Some(value)))
        };
        // Without its first axis a family has nothing along which its models grow.
        let axes = if family.axes.first().is_some_and(|first| free(&first)) { family.axes } else { &[] };
        let values: Vec<Values> = axes.iter().filter(free).map(|axis| Values::new(axis, shape)).collect();
        Grid { base, axes: values }
    }

    /// How many models.
    pub(super) fn len(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// Whether there is one model alone.
    pub(super) fn is_single(&self) -> bool {
        self.len() == 1
    }

    /// How many axes.
    pub(super) fn axes(&self) -> usize {
        self.axes.len()
    }

    /// Values along the first axis.
    pub(super) fn sizes(&self) -> usize {
        self.axes.first().map_or(1, |axis| axis.values.len())
    }

    /// Whether a label's codec is given a parameter.
    pub(super) fn gives(label: &Label, name: &str) -> bool {
        label.codec.params.iter().any(|(key, _)| key == name)
    }

    /// The label of a point.
    pub(super) fn label(&self, point: &[usize]) -> Label {
        let mut label = self.base.clone();
        for (axis, &at) in self.axes.iter().zip(point) {
            axis.axis.parameters.iter().for_each(|parameter| set(&mut label, parameter, axis.values[at]));
        }
        label
    }

    /// The label of a point with another value along the first axis.
    pub(super) fn label_between(&self, point: &[usize], value: usize) -> Label {
        let mut label = self.label(point);
        for parameter in self.axes.first().map_or(&[][..], |axis| axis.axis.parameters) {
            set(&mut label, parameter, &value.to_string());
        }
        label
    }

    /// The label of a point with `parameter` in place of the first axis.
    pub(super) fn label_by(&self, point: &[usize], parameter: &str, value: f64) -> Label {
        let mut label = self.label(point);
        for parameter in self.axes.first().map_or(&[][..], |axis| axis.axis.parameters) {
            unset(&mut label, parameter);
        }
        set(&mut label, parameter, &value.to_string());
        label
    }

    /// Where a point is for a [`super::surrogate::Surrogate`].
    pub(super) fn places(&self, point: &[usize]) -> Vec<Place> {
        self.axes.iter().zip(point).map(|(axis, &at)| axis.places[at]).collect()
    }

    /// How much each axis matters to the error: in which numbers a model is stored hardly does.
    pub(super) fn scales_of_error(&self) -> Vec<f64> {
        self.axes.iter().map(|axis| if axis.axis.stored { STORED } else { 1.0 }).collect()
    }

    /// Whether two points differ in their size and in the numbers in which they are stored alone.
    pub(super) fn is_same_but_stored(&self, a: &[usize], b: &[usize]) -> bool {
        self.axes.iter().zip(a.iter().zip(b)).skip(1).all(|(axis, (a, b))| axis.axis.stored || a == b)
    }

    /// The configuration with which a search starts, at the middle of the first axis.
    pub(super) fn start(&self, shape: Shape) -> Point {
        self.axes.iter().map(|axis| axis.start(shape)).collect()
    }

    /// The last value of every axis.
    pub(super) fn largest(&self) -> Point {
        self.axes.iter().map(|axis| axis.values.len() - 1).collect()
    }

    /// Every point, the first axis fastest.
    pub(super) fn points(&self) -> Vec<Point> {
        let mut points = vec![Point::new()];
        for axis in self.axes.iter().rev() {
            let longer = |point: Point| (0..axis.values.len()).map(move |at| [&[at], &point[..]].concat());
            points = points.into_iter().flat_map(longer).collect();
        }
        points
    }

    /// A point for each configuration of the axes beside the first, which is at 0.
    pub(super) fn configurations(&self) -> Vec<Point> {
        self.points().into_iter().filter(|point| point.first().is_none_or(|at| *at == 0)).collect()
    }

    /// The start with one other axis changed: to the ends of an axis of numbers, to each name of the others.
    pub(super) fn changes(&self, start: &[usize]) -> Vec<Point> {
        let mut changes = Vec::new();
        for (i, axis) in self.axes.iter().enumerate().skip(1) {
            let last = axis.values.len() - 1;
            let numbers = matches!(axis.places[0], Place::Number(_));
            for at in (0..=last).filter(|at| *at != start[i] && (!numbers || [0, last].contains(at))) {
                let mut point = start.to_vec();
                point[i] = at;
                changes.push(point);
            }
        }
        changes
    }

    /// The whole numbers of two neighbours along the first axis, where those between them are values too.
    pub(super) fn numbers(&self, at: usize, other: usize) -> Option<[usize; 2]> {
        let axis = self.axes.first().filter(|axis| axis.axis.whole)?;
        let number = |at: usize| axis.values.get(at)?.parse().ok();
        Some([number(at)?, number(other)?])
    }

    /// The first place along the first axis whose number is at least, or as a bound at most, `number`; the last where there is none.
    pub(super) fn place_of(&self, number: f64) -> usize {
        let Some(axis) = self.axes.first() else { return 0 };
        let values: Vec<f64> = axis.values.iter().filter_map(|value| value.parse().ok()).collect();
        let descends = values.first() > values.last();
        let reached = |value: &f64| if descends { *value <= number } else { *value >= number };
        values.iter().position(reached).unwrap_or(axis.values.len() - 1)
    }

    /// The value of a point along the first axis.
    pub(super) fn size_of(&self, point: &[usize]) -> &str {
        self.axes.first().zip(point.first()).map_or("", |(axis, &at)| axis.values[at])
    }
}

impl Values {
    fn new(axis: &'static Axis, shape: Shape) -> Values {
        let numbers: Vec<Option<f64>> = axis.values.iter().map(|value| value.parse().ok()).collect();
        let number = |at: usize| numbers[at].unwrap_or(0.0);
        let kept = (0..axis.values.len()).filter(|&at| {
            let least = |limit: usize| at == 0 || number(at - 1) < limit as f64;
            match axis.extent {
                Extent::Free => true,
                Extent::Samples => least(shape.samples),
                Extent::Responses => least(shape.responses),
                Extent::Lights => least(shape.lights),
                Extent::Bands => number(at) * number(at) <= shape.lights as f64,
            }
        });
        let kept: Vec<usize> = kept.collect();
        let numeric = numbers.iter().all(|number| number.is_some_and(|number| number > 0.0));
        let ends = [kept.first(), kept.last()].map(|at| at.map_or(0.0, |&at| number(at).ln()));
        let place = |&at: &usize| match numeric {
            true => {
                Place::Number((number(at).ln() - ends[0]) / if ends[1] == ends[0] { 1.0 } else { ends[1] - ends[0] })
            }
            false => Place::Name(at),
        };
        Values {
            axis,
            places: kept.iter().map(place).collect(),
            values: kept.iter().map(|&at| axis.values[at]).collect(),
        }
    }

    fn start(&self, shape: Shape) -> usize {
        let last = self.values.len() - 1;
        match self.axis.start {
            Start::First => 0,
            Start::Middle => last / 2,
            Start::Balanced => {
                let balanced = shape.samples as f64 / (shape.responses * shape.lights).max(1) as f64;
                let above = |value: &&str| value.parse::<f64>().is_ok_and(|number| number >= balanced);
                self.values.iter().position(above).unwrap_or(last)
            }
        }
    }
}

/// The stage of a label and the name that `stage:parameter` names in it.
fn stage_of<'a>(label: &'a mut Label, parameter: &'a str) -> Option<(&'a mut Stage, &'a str)> {
    let (stage, name) = parameter.split_once(':')?;
    [&mut label.transform, &mut label.codec].into_iter().find(|s| s.name == stage).map(|stage| (stage, name))
}

fn value<'a>(label: &'a Label, parameter: &str) -> Option<&'a str> {
    let (stage, name) = parameter.split_once(':')?;
    let of = [&label.transform, &label.codec].into_iter().find(|s| s.name == stage)?;
    of.params.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
}

/// Gives a label's parameter a value.
pub(super) fn set(label: &mut Label, parameter: &str, value: &str) {
    unset(label, parameter);
    if let Some((stage, name)) = stage_of(label, parameter) {
        stage.params.push((name.into(), value.into()));
    }
}

fn unset(label: &mut Label, parameter: &str) {
    if let Some((stage, name)) = stage_of(label, parameter) {
        stage.params.retain(|(key, _)| key != name);
    }
}
