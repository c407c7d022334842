//! `Model`: a baked body, checked once and read in place.

use std::sync::Arc;

use chaincell_host::bake::{ImageBytes, Notes};
use chaincell_host::cli::model_file;
use chaincell_host::engine::{rest_m, to_m};
use chaincell_host::files::whole::write_whole;
use chaincell_kernel::Model as Image;
use numpy::ndarray::{Array2, ArrayView1};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use self_cell::self_cell;

use crate::bake::{bake, mesh_options};
use crate::errors::Class;
use crate::given::Given;
use crate::mesh;
use crate::numbers::{self, bytes};
use crate::signals::aside;

self_cell!(
    /// An image with the model that reads it.
    pub(crate) struct Body {
        owner: ImageBytes,
        #[covariant]
        dependent: Image,
    }
);

impl Body {
    /// Checks an image; `place` is where it came from, for errors.
    fn read(image: ImageBytes, place: &str) -> PyResult<Arc<Self>> {
        let read = Self::try_new(image, |image| model_file::parse(image, place.as_ref()));
        read.map(Arc::new).map_err(|why| Class::Model.host(why))
    }

    /// The model.
    pub(crate) fn model<'a>(&'a self) -> Image<'a> {
        *self.borrow_dependent()
    }

    fn bytes(&self) -> &[u8] {
        self.borrow_owner().as_bytes()
    }
}

/// A baked body: what `chaincell bake` writes. It never changes, threads may share it, and it can be
/// pickled; `bytes(model)` are those of the model file.
///
/// >>> model = chaincell.Model.bake_mesh("organ:500", young_pa=5000)
/// >>> model
/// <chaincell.Model: 499 cells, 2685 links, checksum ...>
/// >>> model.rest_m.shape
/// (499, 3)
#[pyclass(frozen, module = "chaincell")]
pub(crate) struct Model {
    pub(crate) body: Arc<Body>,
}

#[pymethods]
impl Model {
    /// Bakes arrays: a mesh of tetrahedra, or a closed surface that it fills with tetrahedra.
    ///
    /// - `points`: nodes, (nodes, 3), in units of `unit_m` metres.
    /// - `tets`: corners of the tetrahedra, (tetrahedra, 4), ids of points from 0.
    /// - `triangles`: corners of a closed surface, (triangles, 3), in place of `tets`, with `fill_m`.
    /// - `options`: as of `chaincell bake`, with their units, see `chaincell.options.BakeOptions`.
    ///
    /// Raises `ModelError` for a mesh that cannot be baked, `ArgumentError` for a wrong shape or value.
    ///
    /// >>> points = [[0, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, 10], [10, 10, 10]]  # mm
    /// >>> tets = [[0, 1, 2, 3], [1, 2, 3, 4]]
    /// >>> chaincell.Model.bake(points, tets, unit_m=0.001, young_pa=5000, fixed=[0, 1, 2]).cells
    /// 5
    #[staticmethod]
    #[pyo3(signature = (points, tets=None, *, triangles=None, **options))]
    fn bake(
        py: Python<'_>,
        points: &Bound<'_, PyAny>,
        tets: Option<&Bound<'_, PyAny>>,
        triangles: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let given = Given::of_bake(options)?;
        let mesh = mesh::of_arrays(py, points, tets, triangles, mesh_options(&given)?)?;
        Self::baked(py, bake(py, Arc::new(mesh), &given)?)
    }

    /// Bakes a mesh file, a generator, or an object with `points` and `cells` as meshio's.
    ///
    /// - `mesh`: a path; a text such as "organ:500", "box:7x7x5x0.01"; or the object.
    /// - `options`: as of `chaincell bake`, with their units, see `chaincell.options.BakeOptions`;
    ///   a surface (STL, OBJ, PLY) takes `fill_m`, a file in millimetres `unit_m=0.001`.
    ///
    /// Raises `ModelError` for a mesh that cannot be read or baked, `ArgumentError` for a wrong value.
    ///
    /// >>> chaincell.Model.bake_mesh("box:7x7x5x0.01", young_pa=5000, poisson=0.45).cells
    /// 245
    #[staticmethod]
    #[pyo3(signature = (mesh, **options))]
    fn bake_mesh(
        py: Python<'_>,
        mesh: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let given = Given::of_bake(options)?;
        let mesh = mesh::of_any(mesh, mesh_options(&given)?)?;
        Self::baked(py, bake(py, Arc::new(mesh), &given)?)
    }

    /// Reads a model file of `chaincell bake` or `save`, from `path`.
    ///
    /// Raises `ModelError` where the file is missing, damaged, or of another release.
    ///
    /// >>> chaincell.Model.load("liver.chaincell").checksum == model.checksum
    /// True
    #[staticmethod]
    fn load(py: Python<'_>, path: &Bound<'_, PyAny>) -> PyResult<Self> {
        let path = numbers::path("path", path)?;
        aside(py, move || {
            let image = model_file::read(&path).map_err(|why| Class::Model.host(why))?;
            Ok(Self { body: Body::read(image, &path.display().to_string())? })
        })?
    }

    /// Reads the bytes of a model file; `image` is bytes or a bytearray.
    ///
    /// Raises `ModelError` where they are no model of this release.
    ///
    /// >>> chaincell.Model.from_bytes(bytes(model)).cells == model.cells
    /// True
    #[staticmethod]
    fn from_bytes(py: Python<'_>, image: &Bound<'_, PyAny>) -> PyResult<Self> {
        let image = bytes("image", image)?;
        py.detach(|| Ok(Self { body: Body::read(ImageBytes::copy(&image), "bytes")? }))
    }

    /// Writes the model file to `path`, whole or not at all.
    ///
    /// Raises `ModelError` where it cannot be written.
    ///
    /// >>> model.save("liver.chaincell")
    fn save(&self, py: Python<'_>, path: &Bound<'_, PyAny>) -> PyResult<()> {
        let path = numbers::path("path", path)?;
        py.detach(|| write_whole(&path, self.body.bytes())).map_err(|why| Class::Model.host(why))
    }

    /// The bytes of the model file, a copy.
    fn __bytes__<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.body.bytes())
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let from_bytes = py.get_type::<Self>().getattr("from_bytes")?;
        Ok((from_bytes, (self.__bytes__(py),)))
    }

    /// Bytes of the model file, uint8 (bytes,): a view that cannot be written.
    #[getter]
    fn image<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u8>> {
        let bytes = ArrayView1::from(slf.get().body.bytes());
        // SAFETY: the image lies on the heap, is never changed, and is dropped with the object that
        // the array holds.
        #[allow(unsafe_code, reason = "a view instead of a copy")]
        let array = unsafe { PyArray1::borrow_from_array(&bytes, slf.clone().into_any()) };
        array.readwrite().make_nonwriteable();
        array
    }

    /// Number of cells, the nodes whose positions are computed.
    #[getter]
    fn cells(&self) -> usize {
        self.body.model().body_cells()
    }

    /// Number of links, the edges between two cells.
    #[getter]
    fn links(&self) -> usize {
        self.body.model().links()
    }

    /// Number of nodes that results show: that of the cells, without `cells` in the options.
    #[getter]
    fn nodes(&self) -> usize {
        self.rest().0.len()
    }

    /// Mean link length [m].
    #[getter]
    fn unit_m(&self) -> f32 {
        self.body.model().unit_m()
    }

    /// Checksum of the bytes, 8 hexadecimal digits.
    #[getter]
    pub(crate) fn checksum(&self) -> String {
        format!("{:08x}", self.body.model().checksum())
    }

    /// Whether tools such as "probe:0.012" can press on the triangles of the surface.
    #[getter]
    fn has_contact_surface(&self) -> bool {
        self.body.model().has_contact_surface()
    }

    /// Ids of the nodes that results show, ascending, uint32 (nodes,), a copy.
    #[getter]
    fn node_ids<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.rest().0.into_pyarray(py)
    }

    /// Positions at rest [m], float64 (nodes, 3), in the order of `node_ids`, a copy.
    #[getter]
    fn rest_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(self.rest().1).into_pyarray(py)
    }

    /// Ids of the nodes of fixed cells, ascending, uint32 (fixed,), a copy.
    #[getter]
    fn fixed<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        let model = self.body.model();
        let mut ids: Vec<u32> = model.fixed().iter().map(|&cell| id(&model, cell)).collect();
        ids.sort_unstable();
        ids.into_pyarray(py)
    }

    /// Ids of the corners of the surface's triangles, counter-clockwise from outside, uint32
    /// (triangles, 3), a copy.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        let model = self.body.model();
        let corners = |of: &[u16; 3]| of.map(|cell| id(&model, cell));
        let found = match model.fine_nodes() {
            0 => model.triangles().iter().map(corners).collect(),
            _ => model.fine_triangles().to_vec(),
        };
        rows(found).into_pyarray(py)
    }

    /// Ids of the corners of the tetrahedra, uint32 (tetrahedra, 4), a copy.
    #[getter]
    fn tetrahedra<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        let model = self.body.model();
        let corners = |of: &[u16; 4]| of.map(|cell| id(&model, cell));
        let found = match model.fine_nodes() {
            0 => model.tetrahedra().iter().map(corners).collect(),
            _ => model.fine_tetrahedra().to_vec(),
        };
        rows(found).into_pyarray(py)
    }

    /// Ids of the nodes of each named group of the mesh: name to uint32 (nodes,), copies.
    #[getter]
    fn groups<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let groups = PyDict::new(py);
        for (name, ids) in Notes::read(&self.body.model()).groups {
            groups.set_item(name, ids.into_pyarray(py))?;
        }
        Ok(groups)
    }

    /// Shows the body at rest by PyVista: in a notebook in place, else in a window.
    ///
    /// `options` go to `pyvista.Plotter.show`, such as `screenshot="body.png"`. Returns what that
    /// returns. Raises `ImportError` where PyVista is not installed.
    ///
    /// >>> model.show()  # doctest: +SKIP
    #[pyo3(signature = (**options))]
    fn show<'py>(
        slf: &Bound<'py, Self>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rest_m = slf.getattr("rest_m")?;
        slf.py().import("chaincell.pictures")?.call_method("show", (slf, rest_m), options)
    }

    fn __repr__(&self) -> String {
        let model = self.body.model();
        format!(
            "<chaincell.Model: {} cells, {} links, checksum {}>",
            model.body_cells(),
            model.links(),
            self.checksum()
        )
    }
}

impl Model {
    fn baked(py: Python<'_>, image: ImageBytes) -> PyResult<Self> {
        py.detach(|| Ok(Self { body: Body::read(image, "baked")? }))
    }

    /// Ids and positions at rest \[m\] of what results show, by ascending id.
    fn rest(&self) -> (Vec<u32>, Vec<[f64; 3]>) {
        let model = self.body.model();
        if model.fine_nodes() > 0 {
            let fine = (0..model.fine_nodes()).filter_map(|node| {
                let rest = model.fine_rest(node)?;
                Some((node as u32, to_m(&model, rest.map(f64::from))))
            });
            return fine.unzip();
        }
        let cell = |cell: usize| (id(&model, cell as u16), rest_m(&model, cell));
        let mut all: Vec<(u32, [f64; 3])> = (0..model.body_cells()).map(cell).collect();
        all.sort_unstable_by_key(|(id, _)| *id);
        all.into_iter().unzip()
    }
}

/// Input id of a cell.
fn id(model: &Image<'_>, cell: u16) -> u32 {
    model.input_id().get(usize::from(cell)).copied().unwrap_or(u32::MAX)
}

/// Rows as an array of two dimensions.
pub(crate) fn rows<T: Copy + Default, const N: usize>(rows: Vec<[T; N]>) -> Array2<T> {
    let shape = (rows.len(), N);
    Array2::from_shape_vec(shape, rows.into_flattened()).unwrap_or_default()
}

/// A number of each row, as an array.
pub(crate) fn column<'py, R, T: numpy::Element>(
    py: Python<'py>,
    rows: &[R],
    of: impl Fn(&R) -> T,
) -> Bound<'py, PyArray1<T>> {
    rows.iter().map(of).collect::<Vec<T>>().into_pyarray(py)
}
