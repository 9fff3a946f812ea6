//! The classes and functions that a pickle may name. None of them is called: each is a name for the reader.

/// What a name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Global {
    /// `numpy._reconstruct(class, (0,), 'b')`; shape, type and bytes are in the state.
    NumpyArray,
    /// `numpy._frombuffer(bytes, dtype, shape, order)`, of protocol 5.
    NumpyFromBuffer,
    /// `numpy.ndarray`, only as an argument.
    NumpyClass,
    /// `numpy.dtype(text, …)`; the byte order is in the state.
    NumpyType,
    /// `numpy.scalar(dtype, bytes)`.
    NumpyScalar,
    /// `scipy.sparse`, compressed columns.
    SparseColumns,
    /// `scipy.sparse`, compressed rows.
    SparseRows,
    /// `chumpy.ch.Ch`: an array in the state's `x`.
    Chumpy,
    /// `chumpy.reordering.Select`: elements `idxs` of `a`, in `preferred_shape`.
    ChumpySelect,
    /// `chumpy.reordering.Reshape`: `a` in `newshape`.
    ChumpyReshape,
    /// Another expression of chumpy's: it may stand in a file, under keys that nobody reads.
    ChumpyOther,
    /// `_codecs.encode(text, 'latin1')`: how Python 3 writes bytes in protocol 2.
    Encode,
    /// `bytes(…)` or `bytearray(…)`.
    Bytes,
    /// `copy_reg._reconstructor(class, object, None)`: an object of `class`.
    Reconstructor,
    /// `copy_reg.__newobj__(class, …)`: the same.
    NewObject,
    /// `collections.OrderedDict(pairs)`.
    OrderedDict,
    /// `object`, and containers under keys that nobody reads.
    Builtin,
}

/// Every module and name but chumpy's others.
const ALLOWED: &[(&str, &str, Global)] = &[
    ("numpy", "ndarray", Global::NumpyClass),
    ("numpy", "dtype", Global::NumpyType),
    ("numpy.core.multiarray", "_reconstruct", Global::NumpyArray),
    ("numpy._core.multiarray", "_reconstruct", Global::NumpyArray),
    ("numpy.core.multiarray", "scalar", Global::NumpyScalar),
    ("numpy._core.multiarray", "scalar", Global::NumpyScalar),
    ("numpy.core.numeric", "_frombuffer", Global::NumpyFromBuffer),
    (
        "numpy._core.numeric",
        "_frombuffer",
        Global::NumpyFromBuffer,
    ),
    ("scipy.sparse.csc", "csc_matrix", Global::SparseColumns),
    ("scipy.sparse._csc", "csc_matrix", Global::SparseColumns),
    ("scipy.sparse._csc", "csc_array", Global::SparseColumns),
    ("scipy.sparse.csr", "csr_matrix", Global::SparseRows),
    ("scipy.sparse._csr", "csr_matrix", Global::SparseRows),
    ("scipy.sparse._csr", "csr_array", Global::SparseRows),
    ("chumpy.ch", "Ch", Global::Chumpy),
    ("chumpy.reordering", "Select", Global::ChumpySelect),
    ("chumpy.reordering", "Reshape", Global::ChumpyReshape),
    ("_codecs", "encode", Global::Encode),
    ("__builtin__", "bytes", Global::Bytes),
    ("builtins", "bytes", Global::Bytes),
    ("__builtin__", "bytearray", Global::Bytes),
    ("builtins", "bytearray", Global::Bytes),
    ("copy_reg", "_reconstructor", Global::Reconstructor),
    ("copyreg", "_reconstructor", Global::Reconstructor),
    ("copy_reg", "__newobj__", Global::NewObject),
    ("copyreg", "__newobj__", Global::NewObject),
    ("collections", "OrderedDict", Global::OrderedDict),
    ("__builtin__", "object", Global::Builtin),
    ("builtins", "object", Global::Builtin),
    ("__builtin__", "set", Global::Builtin),
    ("builtins", "set", Global::Builtin),
    ("__builtin__", "frozenset", Global::Builtin),
    ("builtins", "frozenset", Global::Builtin),
    ("__builtin__", "list", Global::Builtin),
    ("builtins", "list", Global::Builtin),
    ("__builtin__", "dict", Global::Builtin),
    ("builtins", "dict", Global::Builtin),
];

/// The global of this name, if it is on the list.
pub(super) fn find(module: &str, name: &str) -> Option<Global> {
    let listed = ALLOWED.iter().find(|g| (g.0, g.1) == (module, name));
    let chumpy = || {
        let inside = module == "chumpy" || module.starts_with("chumpy.");
        inside.then_some(Global::ChumpyOther)
    };
    listed.map(|g| g.2).or_else(chumpy)
}
