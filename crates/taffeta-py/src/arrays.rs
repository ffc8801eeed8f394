//! Numpy arrays: new ones, and those of the user that are written to.

use crate::errors::Failure;
use numpy::{
    Element, IntoPyArray, PyArray2, PyArrayDescrMethods, PyArrayMethods, PyUntypedArray,
    PyUntypedArrayMethods, dtype,
};
use pyo3::prelude::*;
use pyo3::types::PyBool;
use taffeta::Precision;

/// Rows of three numbers, in the arithmetic of the run.
pub enum Rows {
    F32(Vec<[f32; 3]>),
    F64(Vec<[f64; 3]>),
}

impl Rows {
    /// None, in an arithmetic.
    pub fn empty(precision: Precision) -> Self {
        match precision {
            Precision::F32 => Self::F32(Vec::new()),
            Precision::F64 => Self::F64(Vec::new()),
        }
    }

    /// These, and leaves none.
    pub fn take(&mut self) -> Self {
        match self {
            Self::F32(all) => Self::F32(std::mem::take(all)),
            Self::F64(all) => Self::F64(std::mem::take(all)),
        }
    }

    /// The chosen rows as a new array [n, 3].
    pub fn to_array(&self, py: Python<'_>, rows: std::ops::Range<usize>) -> PyResult<Py<PyAny>> {
        match self {
            Self::F32(all) => array(py, all[rows].to_vec()),
            Self::F64(all) => array(py, all[rows].to_vec()),
        }
    }

    /// Writes the chosen rows into an array that the user gives.
    pub fn write(&self, out: &Bound<'_, PyAny>, rows: std::ops::Range<usize>) -> Result<(), Failure> {
        let shape = [rows.len(), 3];
        match self {
            Self::F32(all) => write(out, &shape, all[rows].as_flattened()),
            Self::F64(all) => write(out, &shape, all[rows].as_flattened()),
        }
    }
}

/// A new array [n, N], to which the numbers go without a copy.
pub fn array<T: Element, const N: usize>(py: Python<'_>, rows: Vec<[T; N]>) -> PyResult<Py<PyAny>> {
    let count = rows.len();
    Ok(rows.into_flattened().into_pyarray(py).reshape([count, N])?.into_any().unbind())
}

/// Writes `numbers` into the array `out`, which must be of this shape and type, in one piece and writeable.
pub fn write<T: Element + Copy>(
    out: &Bound<'_, PyAny>,
    shape: &[usize],
    numbers: &[T],
) -> Result<(), Failure> {
    with(out, shape, |all: &mut [T]| all.copy_from_slice(numbers))
}

/// Gives `work` the numbers of the array `out`, which must be of this shape and type, in one piece and writeable.
pub fn with<T: Element + Copy, R>(
    out: &Bound<'_, PyAny>,
    shape: &[usize],
    work: impl FnOnce(&mut [T]) -> R,
) -> Result<R, Failure> {
    let refuse = |what: String| Failure::input(format!("out: {what}"));
    let Ok(array) = out.cast::<PyUntypedArray>() else {
        return Err(refuse(format!("is no numpy array but {}", out.get_type().name()?)));
    };
    let wanted = dtype::<T>(out.py());
    if !array.dtype().is_equiv_to(&wanted) {
        return Err(refuse(format!("has the dtype {}; {wanted} would do", array.dtype())));
    }
    if array.shape() != shape {
        return Err(refuse(format!("has the shape {:?}; {shape:?} would do", array.shape())));
    }
    if !array.is_c_contiguous() {
        return Err(refuse("is not contiguous; numpy.ascontiguousarray makes one that is".to_owned()));
    }
    let array = out.cast::<numpy::PyArrayDyn<T>>().map_err(PyErr::from)?;
    let mut array =
        array.try_readwrite().map_err(|error| refuse(format!("cannot be written to: {error}")))?;
    let all = array.as_slice_mut().map_err(|error| refuse(error.to_string()))?;
    Ok(work(all))
}

/// Vectors of three numbers: an array or list [3], or [n, 3] where there are n of them.
pub fn vectors(value: &Bound<'_, PyAny>, count: usize, what: &str) -> Result<Vec<[f64; 3]>, Failure> {
    if let Ok(one) = value.extract::<[f64; 3]>() {
        return Ok(vec![one; count]);
    }
    let unfit = || Failure::input(format!("{what} is no array of numbers [3] or [{count}, 3]"));
    let numpy = value.py().import("numpy")?;
    let array = numpy.call_method1("ascontiguousarray", (value, "f8")).map_err(|_| unfit())?;
    let array = array.cast::<PyArray2<f64>>().map_err(|_| unfit())?;
    if array.shape() != [count, 3] {
        return Err(unfit());
    }
    let numbers = array.to_vec().map_err(|_| unfit())?;
    Ok(numbers.as_chunks().0.to_vec())
}

/// The same for so many worlds, one after the other: an array [3] or [worlds, 3], the same for all n, or [worlds, n, 3].
pub fn vectors_of_worlds(
    value: &Bound<'_, PyAny>,
    [worlds, count]: [usize; 2],
    what: &str,
) -> Result<Vec<[f64; 3]>, Failure> {
    let unfit = || {
        Failure::input(format!("{what} is no array of numbers [3], [{worlds}, 3] or [{worlds}, {count}, 3]"))
    };
    let numpy = value.py().import("numpy")?;
    let array = numpy.call_method1("ascontiguousarray", (value, "f8")).map_err(|_| unfit())?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    let numbers = array.call_method0("ravel")?;
    let numbers =
        numbers.cast::<numpy::PyArray1<f64>>().map_err(|_| unfit())?.to_vec().map_err(|_| unfit())?;
    let rows: &[[f64; 3]] = numbers.as_chunks().0;
    match shape[..] {
        [3] => Ok(vec![rows[0]; worlds * count]),
        [all, 3] if all == worlds => {
            Ok(rows.iter().flat_map(|row| std::iter::repeat_n(*row, count)).collect())
        }
        [all, each, 3] if all == worlds && each == count => Ok(rows.to_vec()),
        _ => Err(unfit()),
    }
}

/// Vertices: one number, or a list or array of them. Truths, which Python takes for 0 and 1, are none.
pub fn vertices(value: &Bound<'_, PyAny>) -> Result<Vec<usize>, Failure> {
    let unfit = || Failure::input("vertices are whole numbers from 0 on, one or a list or array of them");
    let is_boolean = |one: &Bound<'_, PyAny>| one.is_instance_of::<PyBool>();
    let booleans = || Failure::input("vertices are booleans; numpy.flatnonzero makes numbers of them");
    let value = if value.hasattr("tolist")? { &value.call_method0("tolist")? } else { value };
    if is_boolean(value) {
        return Err(booleans());
    }
    if let Ok(one) = value.extract::<i64>() {
        return Ok(vec![usize::try_from(one).map_err(|_| unfit())?]);
    }
    if value.try_iter().is_ok_and(|mut all| all.any(|one| one.is_ok_and(|one| is_boolean(&one)))) {
        return Err(booleans());
    }
    value.extract::<Vec<usize>>().map_err(|_| unfit())
}
