//! NumPy archives of reference data.

use std::fs::File;
use std::path::{Path, PathBuf};

use ndarray::{ArrayD, IxDyn, OwnedRepr};
use ndarray_npy::{NpzReader, ReadNpzError, ReadableElement};

use chaincell_host::error::{Error, Result};
use chaincell_host::input;

/// An open archive.
pub struct Npz {
    path: PathBuf,
    reader: NpzReader<File>,
}

impl Npz {
    /// Opens an archive.
    ///
    /// # Errors
    /// A file that cannot be read or is no archive.
    pub fn open(path: &Path) -> Result<Self> {
        let failed = |why: &dyn std::fmt::Display| Error::file("read", path, why);
        let file = input::open(path).map_err(|why| failed(&why))?;
        let reader = NpzReader::new(file).map_err(|why| failed(&why))?;
        Ok(Self { path: path.to_owned(), reader })
    }

    fn array<T: ReadableElement + Clone>(
        &mut self,
        name: &str,
    ) -> std::result::Result<Vec<T>, ReadNpzError> {
        let array: ArrayD<T> =
            self.reader.by_name::<OwnedRepr<T>, IxDyn>(&format!("{name}.npy"))?;
        Ok(array.iter().cloned().collect())
    }

    fn failed(&self, name: &str, why: impl std::fmt::Display) -> Error {
        Error::file("read", &self.path, format_args!("array {name}: {why}"))
    }

    /// Real numbers, row by row.
    ///
    /// # Errors
    /// An array that is missing or not of `f64`.
    pub fn reals(&mut self, name: &str) -> Result<Vec<f64>> {
        self.array(name).map_err(|why| self.failed(name, why))
    }

    /// Vectors: rows of three real numbers.
    ///
    /// # Errors
    /// As [`Self::reals`], and a number that is no multiple of three.
    pub fn vectors(&mut self, name: &str) -> Result<Vec<[f64; 3]>> {
        let reals = self.reals(name)?;
        match reals.as_chunks() {
            (rows, []) => Ok(rows.to_vec()),
            _ => Err(self.failed(name, "not of rows of three")),
        }
    }

    /// Whole numbers, row by row, stored in 32 or 64 bits.
    ///
    /// # Errors
    /// An array that is missing, of other numbers, or of numbers beyond 32 bits.
    pub fn ids(&mut self, name: &str) -> Result<Vec<u32>> {
        let wide = match self.array::<i32>(name) {
            Ok(narrow) => narrow.into_iter().map(i64::from).collect(),
            Err(_) => self.array::<i64>(name).map_err(|why| self.failed(name, why))?,
        };
        let narrow: std::result::Result<Vec<u32>, _> =
            wide.into_iter().map(u32::try_from).collect();
        narrow.map_err(|why| self.failed(name, why))
    }

    /// Rows of `N` whole numbers.
    ///
    /// # Errors
    /// As [`Self::ids`], and a number that is no multiple of `N`.
    pub fn rows<const N: usize>(&mut self, name: &str) -> Result<Vec<[u32; N]>> {
        let ids = self.ids(name)?;
        match ids.as_chunks() {
            (rows, []) => Ok(rows.to_vec()),
            _ => Err(self.failed(name, format_args!("not of rows of {N}"))),
        }
    }
}
