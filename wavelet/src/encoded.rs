//! A truncated matrix: one of the layouts behind one face.

use crate::columns::Columns;
use crate::keep::Kept;
use crate::rows::Rows;
use crate::stored::{Index, Value};
use crate::truncate::Order;
use ndarray::{ArrayView2, ArrayViewMut2};
use prt_transfer::sections::broken;
use prt_transfer::{Encoded, Flops, Restore, Result, Shape, Sink, Source};

/// The largest coefficients of each row. With n of them stored, relighting takes n multiplications and n additions, or with
/// `order=columns` as many as there are stored in the columns whose light coefficient is not 0; with `bits` below 32 one more
/// multiplication for each row.
pub struct EncodedTruncate {
    order: Order,
    bits: u32,
    layout: Box<dyn Encoded>,
}

/// A layout of kept elements, generic over the widths of what it stores.
pub(crate) trait Layout: Encoded + Sized + 'static {
    /// Lays out kept elements.
    fn new(shape: Shape, kept: Kept) -> Self;
    /// Reads what [`Encoded::write`] wrote.
    fn read(shape: Shape, source: &mut Source) -> Result<Self>;
}

/// Where a layout comes from.
enum Origin<'a> {
    Kept(Kept),
    Source(&'a mut Source),
}

impl Origin<'_> {
    fn layout(self, shape: Shape, bits: u32, order: Order) -> Result<Box<dyn Encoded>> {
        match shape.lights {
            0..=0x100 => self.with_index::<u8>(shape, bits, order),
            0x101..=0x1_0000 => self.with_index::<u16>(shape, bits, order),
            _ => self.with_index::<u32>(shape, bits, order),
        }
    }
    fn with_index<I: Index>(self, shape: Shape, bits: u32, order: Order) -> Result<Box<dyn Encoded>> {
        match bits {
            8 => self.with_value::<I, i8>(shape, order),
            16 => self.with_value::<I, i16>(shape, order),
            _ => self.with_value::<I, f32>(shape, order),
        }
    }
    fn with_value<I: Index, V: Value>(self, shape: Shape, order: Order) -> Result<Box<dyn Encoded>> {
        match order {
            Order::Rows => self.build::<Rows<I, V>>(shape),
            Order::Columns => self.build::<Columns<I, V>>(shape),
        }
    }
    fn build<L: Layout>(self, shape: Shape) -> Result<Box<dyn Encoded>> {
        Ok(Box::new(match self {
            Origin::Kept(kept) => L::new(shape, kept),
            Origin::Source(source) => L::read(shape, source)?,
        }))
    }
}

impl EncodedTruncate {
    pub(crate) fn new(shape: Shape, kept: Kept, bits: u32, order: Order) -> Result<EncodedTruncate> {
        Ok(EncodedTruncate { order, bits, layout: Origin::Kept(kept).layout(shape, bits, order)? })
    }
}

impl Encoded for EncodedTruncate {
    fn shape(&self) -> Shape {
        self.layout.shape()
    }
    fn apply_into(&self, lights: ArrayView2<f32>, out: ArrayViewMut2<f32>) -> Result<()> {
        self.layout.apply_into(lights, out)
    }
    fn row_into(&self, row: usize, out: &mut [f32]) {
        self.layout.row_into(row, out)
    }
    fn flops(&self, light: &[f32]) -> Flops {
        self.layout.flops(light)
    }
    fn write(&self, sink: &mut Sink) {
        sink.put("header/layout", &[self.order as u8, self.bits as u8]);
        self.layout.write(sink);
    }
}

impl Restore for EncodedTruncate {
    const TAG: &'static str = "truncate.1";

    fn read(shape: Shape, source: &mut Source) -> Result<EncodedTruncate> {
        let header: Vec<u8> = source.take_exact("header/layout", 2)?;
        let (order, bits) = match header[..] {
            [0, bits @ (8 | 16 | 32)] => (Order::Rows, bits.into()),
            [1, bits @ (8 | 16 | 32)] => (Order::Columns, bits.into()),
            _ => {
                let expected = "0 (rows) or 1 (columns), then 8, 16 or 32 bits";
                return Err(broken("header/layout", expected, format!("{header:?}")));
            }
        };
        Ok(EncodedTruncate { order, bits, layout: Origin::Source(source).layout(shape, bits, order)? })
    }
}
