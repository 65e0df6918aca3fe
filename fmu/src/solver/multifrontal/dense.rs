//! Register-blocked dense kernels for fronts.
//!
//! Plain loops over fixed-size arrays that the compiler vectorises; they are inlined into functions that are
//! compiled for the machine's vector instructions (`pulp`). Small fronts never leave this module; products that
//! fill a cache go to faer.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use pulp::{Arch, NullaryFnOnce};
use std::ops::{AddAssign, Mul, MulAssign, Neg, SubAssign};

/// Rows of a tile; borders are padded to whole tiles.
pub(super) const ROWS: usize = 8;
/// Columns of a tile: ROWS x COLUMNS sums and their factors fit the registers of AVX2.
pub(super) const COLUMNS: usize = 6;
/// Columns solved for by tiles alone; what lies before them is subtracted as one product.
pub(super) const BLOCK: usize = 240;
/// Operations from which faer's packed product is faster than the unpacked tiles here.
const LARGE_PRODUCT: usize = 1 << 24;

/// Floating-point type of the factors.
pub trait Scalar:
    faer::traits::RealField
    + Copy
    + Default
    + PartialOrd
    + AddAssign
    + SubAssign
    + MulAssign
    + Mul<Output = Self>
    + Neg<Output = Self>
{
    /// Multiplicative identity.
    const ONE: Self;
    /// `self * factor + summand` with one rounding.
    fn mul_add(self, factor: Self, summand: Self) -> Self;
    /// Magnitude.
    fn magnitude(self) -> Self;
    /// Neither infinite nor NaN.
    fn is_number(self) -> bool;
    /// Rounds to this type.
    fn from_f64(value: f64) -> Self;
    /// Widens to double precision.
    fn to_f64(self) -> f64;
}

macro_rules! scalar {
    ($($real:ty),*) => {$(
        impl Scalar for $real {
            const ONE: Self = 1.0;
            #[inline(always)]
            fn mul_add(self, factor: Self, summand: Self) -> Self {
                <$real>::mul_add(self, factor, summand)
            }
            #[inline(always)]
            fn magnitude(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn is_number(self) -> bool {
                self.is_finite()
            }
            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as Self
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
        }
    )*};
}
scalar!(f32, f64);

/// Calls `$function::<T, W>` with the run-time width as the constant W.
macro_rules! by_width {
    ($width:expr, $function:ident ( $($argument:expr),* $(,)? )) => {
        match $width {
            1 => $function::<T, 1>($($argument),*),
            2 => $function::<T, 2>($($argument),*),
            3 => $function::<T, 3>($($argument),*),
            4 => $function::<T, 4>($($argument),*),
            5 => $function::<T, 5>($($argument),*),
            _ => $function::<T, COLUMNS>($($argument),*),
        }
    };
}

/// The first R rows of `a` (columns `stride` apart) times `b`.
#[inline(always)]
fn tile<T: Scalar, const R: usize, const W: usize>(
    a: &[T],
    stride: usize,
    b: &[[T; COLUMNS]],
) -> [[T; R]; W] {
    let mut sum = [[T::default(); R]; W];
    for (column, factors) in a.chunks(stride).zip(b) {
        let Some(x) = column.first_chunk::<R>() else { break };
        for j in 0..W {
            for i in 0..R {
                sum[j][i] = x[i].mul_add(factors[j], sum[j][i]);
            }
        }
    }
    sum
}

/// c -= a b for W columns of `c`, tile by tile; `rows` need not fill the last tile.
#[inline(always)]
fn subtract_columns<T: Scalar, const W: usize>(
    c: &mut [T],
    c_stride: usize,
    a: &[T],
    a_stride: usize,
    b: &[[T; COLUMNS]],
    rows: usize,
) {
    let mut row = 0;
    while row + ROWS <= rows {
        subtract_tile::<T, ROWS, W>(&mut c[row..], c_stride, &a[row..], a_stride, b);
        row += ROWS;
    }
    while row < rows {
        subtract_tile::<T, 1, W>(&mut c[row..], c_stride, &a[row..], a_stride, b);
        row += 1;
    }
}

#[inline(always)]
fn subtract_tile<T: Scalar, const R: usize, const W: usize>(
    c: &mut [T],
    c_stride: usize,
    a: &[T],
    a_stride: usize,
    b: &[[T; COLUMNS]],
) {
    let sum = tile::<T, R, W>(a, a_stride, b);
    for (column, sum) in c.chunks_mut(c_stride).zip(&sum) {
        for (x, &y) in column.iter_mut().zip(sum) {
            *x -= y;
        }
    }
}

/// A factor of a product: entry (k, j) is `values[k * row_stride + j * column_stride]`.
#[derive(Clone, Copy)]
pub(super) struct Factor<'a, T> {
    pub values: &'a [T],
    pub row_stride: usize,
    pub column_stride: usize,
}

impl<'a, T: Scalar> Factor<'a, T> {
    /// Copies `depth` rows of the `width` columns from `column` on.
    #[inline(always)]
    pub fn pack(&self, packed: &mut [[T; COLUMNS]], column: usize, width: usize) {
        for (k, row) in packed.iter_mut().enumerate() {
            let start = k * self.row_stride + column * self.column_stride;
            for (x, y) in row[..width].iter_mut().zip(self.values[start..].iter().step_by(self.column_stride))
            {
                *x = *y;
            }
        }
    }
}

/// c -= a b: `c` is rows x columns, `a` rows x depth, both by columns with their strides; `packed` holds at least `depth` rows.
pub(super) fn subtract_product<T: Scalar>(
    arch: Arch,
    c: (&mut [T], usize),
    (rows, columns, depth): (usize, usize, usize),
    a: (&[T], usize),
    b: Factor<'_, T>,
    packed: &mut [[T; COLUMNS]],
) {
    if rows == 0 || columns == 0 || depth == 0 {
        return;
    }
    if rows * columns * depth >= LARGE_PRODUCT {
        return subtract_large_product(c, (rows, columns, depth), a, b);
    }
    arch.dispatch(Product { c, rows, columns, a, b, packed: &mut packed[..depth] });
}

/// c -= a b of a small product, compiled for the machine's vector instructions in one place: it is long.
struct Product<'a, T> {
    c: (&'a mut [T], usize),
    rows: usize,
    columns: usize,
    a: (&'a [T], usize),
    b: Factor<'a, T>,
    packed: &'a mut [[T; COLUMNS]],
}

impl<T: Scalar> NullaryFnOnce for Product<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { c: (c, c_stride), rows, columns, a, b, packed } = self;
        for column in (0..columns).step_by(COLUMNS) {
            let width = COLUMNS.min(columns - column);
            b.pack(packed, column, width);
            subtract_packed((&mut c[column * c_stride..], c_stride), (rows, width), a, packed);
        }
    }
}

/// c -= a b for at most COLUMNS columns and a packed `b`.
#[inline(always)]
pub(super) fn subtract_packed<T: Scalar>(
    (c, c_stride): (&mut [T], usize),
    (rows, width): (usize, usize),
    (a, a_stride): (&[T], usize),
    b: &[[T; COLUMNS]],
) {
    by_width!(width, subtract_columns(c, c_stride, a, a_stride, b, rows));
}

#[inline(never)]
fn subtract_large_product<T: Scalar>(
    (c, c_stride): (&mut [T], usize),
    (rows, columns, depth): (usize, usize, usize),
    (a, a_stride): (&[T], usize),
    b: Factor<'_, T>,
) {
    let c = MatMut::from_column_major_slice_with_stride_mut(c, rows, columns, c_stride);
    let a = MatRef::from_column_major_slice_with_stride(a, rows, depth, a_stride);
    let b = if b.row_stride == 1 {
        MatRef::from_column_major_slice_with_stride(b.values, depth, columns, b.column_stride)
    } else {
        MatRef::from_row_major_slice_with_stride(b.values, depth, columns, b.row_stride)
    };
    matmul(c, Accum::Add, a, b, -T::ONE, Par::Seq);
}

/// x <- x t^-1 for an upper triangular `t` with unit diagonal, or with `inverse_diagonal`; `x` has `height`
/// rows (whole tiles) and `order` columns.
pub(super) fn solve_from_right<T: Scalar>(
    arch: Arch,
    x: &mut [T],
    (height, order): (usize, usize),
    t: Factor<'_, T>,
    unit: bool,
    packed: &mut [[T; COLUMNS]],
) {
    if height == 0 {
        return;
    }
    for start in (0..order).step_by(BLOCK) {
        let width = BLOCK.min(order - start);
        let (done, rest) = x.split_at_mut(start * height);
        let above = Factor { values: &t.values[start * t.column_stride..], ..t };
        subtract_product(arch, (rest, height), (height, width, start), (done, height), above, packed);
        let corner = Factor { values: &t.values[start * (t.column_stride + t.row_stride)..], ..t };
        arch.dispatch(Corner { x: rest, height, order: width, t: corner, unit, packed });
    }
}

/// [`solve_from_right`] for so few columns that they are solved tile by tile.
struct Corner<'a, T> {
    x: &'a mut [T],
    height: usize,
    order: usize,
    t: Factor<'a, T>,
    unit: bool,
    packed: &'a mut [[T; COLUMNS]],
}

impl<T: Scalar> NullaryFnOnce for Corner<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { x, height, order, t, unit, packed } = self;
        for column in (0..order).step_by(COLUMNS) {
            let width = COLUMNS.min(order - column);
            let packed = &mut packed[..column + width];
            t.pack(packed, column, width);
            if unit {
                for j in 0..width {
                    packed[column + j][j] = T::ONE;
                }
            }
            let (done, rest) = x.split_at_mut(column * height);
            by_width!(width, solve_columns(done, rest, height, packed));
        }
    }
}

/// The first W columns of `rest` <- (rest - done t1) t2^-1, where `t` is t1 above t2 (diagonal inverted).
#[inline(always)]
fn solve_columns<T: Scalar, const W: usize>(done: &[T], rest: &mut [T], height: usize, t: &[[T; COLUMNS]]) {
    let (above, corner) = t.split_at(t.len() - W);
    for row in (0..height).step_by(ROWS) {
        let sum: [[T; ROWS]; W] = match done.get(row..) {
            Some(done) if !above.is_empty() => tile(done, height, above),
            _ => [[T::default(); ROWS]; W],
        };
        let mut x = [[T::default(); ROWS]; W];
        for ((x, column), sum) in x.iter_mut().zip(rest[row..].chunks(height)).zip(&sum) {
            for ((x, &y), &s) in x.iter_mut().zip(column).zip(sum) {
                *x = y - s;
            }
        }
        for j in 0..W {
            for k in 0..j {
                for i in 0..ROWS {
                    x[j][i] = (-x[k][i]).mul_add(corner[k][j], x[j][i]);
                }
            }
            for i in 0..ROWS {
                x[j][i] *= corner[j][j];
            }
        }
        for (column, x) in rest[row..].chunks_mut(height).zip(&x) {
            column[..ROWS].copy_from_slice(x);
        }
    }
}
