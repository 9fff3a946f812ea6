use super::writer::Python::{self, Three, Two};
use super::writer::{build, int, tuple};
use super::*;
use crate::array::Array;

const ROOM: usize = 1 << 16;

fn item(python: Python, body: &[u8]) -> Result<Item, String> {
    parse_array(&python.program(body), ROOM)
}

fn array(python: Python, body: &[u8]) -> Array {
    match item(python, body).unwrap() {
        Item::Dense(array) => array,
        Item::Sparse(_) => panic!("a sparse matrix"),
    }
}

fn refused(program: &[u8], hint: &str) {
    let problem = parse_array(program, ROOM).expect_err(hint);
    assert!(
        problem.contains(hint),
        "{problem:?} says nothing of {hint:?}"
    );
}

#[test]
fn arrays_of_every_type_and_order_are_read() {
    for python in [Two, Three] {
        let one = |descr: &str, data: &[u8]| {
            array(python, &python.array(descr, &[1], false, data)).numbers[0]
        };
        assert_eq!(one("<f8", &0.1f64.to_le_bytes()), 0.1);
        assert_eq!(one(">f4", &1.5f32.to_be_bytes()), 1.5);
        assert_eq!(one("<i4", &(-7i32).to_le_bytes()), -7.0);
        assert_eq!(one(">i8", &(-9i64).to_be_bytes()), -9.0);
        assert_eq!(one("<u4", &u32::MAX.to_le_bytes()), 4294967295.0);
        assert_eq!(one("|u1", &[200]), 200.0);
        assert_eq!(one("|b1", &[1]), 1.0);
        let data: Vec<u8> = (0..6).collect();
        let c = array(python, &python.array("|u1", &[2, 3], false, &data));
        let f = array(python, &python.array("|u1", &[2, 3], true, &data));
        assert_eq!(c.numbers, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(f.numbers, [0.0, 2.0, 4.0, 1.0, 3.0, 5.0]);
        let texts = array(python, &python.array("|S2", &[2], false, b"ab\xe9\0"));
        assert_eq!(texts.texts, ["ab", "é"]);
    }
}

#[test]
fn plain_values_and_wrapped_bytes_are_read() {
    assert_eq!(array(Two, b"I-12\n").numbers, [-12.0]);
    assert_eq!(array(Two, b"I01\n").numbers, [1.0]);
    assert_eq!(array(Two, b"L-5L\n").numbers, [-5.0]);
    assert_eq!(array(Two, b"F2.5\n").numbers, [2.5]);
    assert_eq!(array(Two, &[0x8a, 2, 0, 0xff]).numbers, [-256.0]);
    assert_eq!(array(Two, b"G\x3f\xf8\0\0\0\0\0\0").numbers, [1.5]);
    assert_eq!(array(Two, b"(lp0\nF1\naF2\na").numbers, [1.0, 2.0]);
    assert_eq!(array(Two, b"S'a\\x41\\'\\n'\n").texts, ["aA'\n"]);
    assert_eq!(array(Two, b"V\\u00b5\\U0001F600\xe9\n").texts, ["µ😀é"]);
    // Python 3 writes bytes in protocol 2 as the encoding of a text.
    let text = Three.text("\u{f0}?");
    let bytes = Two.call("_codecs", "encode", &[text, Two.text("latin1")]);
    let class = Two.class("numpy", "ndarray");
    let made = [class, tuple(&[int(0)]), Two.text("b")];
    let made = Two.call("numpy.core.multiarray", "_reconstruct", &made);
    let state = [
        int(1),
        tuple(&[int(1)]),
        Two.element_type("<u2"),
        vec![0x89],
        bytes,
    ];
    assert_eq!(array(Two, &build(made, tuple(&state))).numbers, [16368.0]);
    let scalar = [Two.element_type("<f8"), Two.bytes(&2.5f64.to_le_bytes())];
    let scalar = array(Two, &Two.call("numpy.core.multiarray", "scalar", &scalar));
    assert_eq!((scalar.shape, scalar.numbers), (vec![], vec![2.5]));
    // Numbers of NumPy's in a list.
    let length = [Two.element_type("<i8"), Two.bytes(&7i64.to_le_bytes())];
    let length = Two.call("numpy.core.multiarray", "scalar", &length);
    assert_eq!(array(Two, &tuple(&[int(3), length])).numbers, [3.0, 7.0]);
}

/// A 2 × 3 matrix with a value stored twice, in rows and in columns.
#[test]
fn sparse_matrices_are_read() {
    let state = |python: Python, indices: &[u32], starts: &[u32]| {
        [
            ("_shape", tuple(&[int(2), int(3)])),
            ("indptr", python.u32s(&[starts.len()], starts)),
            ("indices", python.u32s(&[indices.len()], indices)),
            ("data", python.f64s(&[4], &[1.0, 2.0, 3.0, 4.0])),
            ("maxprint", int(50)),
        ]
    };
    let csr = state(Two, &[0, 2, 1, 1], &[0, 2, 4]);
    let csc = state(Three, &[0, 1, 1, 0], &[0, 1, 3, 4]);
    let expected_csc = [vec![(0, 1.0), (2, 4.0)], vec![(1, 2.0), (1, 3.0)]];
    let expected_csr = [vec![(0, 1.0), (2, 2.0)], vec![(1, 3.0), (1, 4.0)]];
    for (python, module, name, state, expected) in [
        (Two, "scipy.sparse.csr", "csr_matrix", &csr, expected_csr),
        (Three, "scipy.sparse._csc", "csc_array", &csc, expected_csc),
    ] {
        let Item::Sparse(matrix) = item(python, &python.object(module, name, state)).unwrap()
        else {
            panic!("{name} is not sparse");
        };
        assert_eq!(matrix.columns, 3);
        assert_eq!(
            matrix.rows.iter().map(<[_]>::to_vec).collect::<Vec<_>>(),
            expected
        );
    }
    for (indices, starts, hint) in [
        (&[0, 3, 1, 1], &[0, 2, 4][..], "not below 3"),
        (&[0, 2, 1, 1], &[0, 5, 4], "divide"),
        (&[0, 2, 1, 1], &[0, 2, 3], "divide"),
        (&[0, 2, 1, 1], &[0, 4], "divide"),
    ] {
        let broken = state(Two, indices, starts);
        let broken = Two.object("scipy.sparse.csr", "csr_matrix", &broken);
        refused(&Two.program(&broken), hint);
    }
}

#[test]
fn chumpy_is_reduced_to_its_value() {
    let ch = Two.object(
        "chumpy.ch",
        "Ch",
        &[("x", Two.f64s(&[2, 2], &[1.0, 2.0, 3.0, 4.0]))],
    );
    let read = array(Two, &ch);
    assert_eq!(
        (read.shape, read.numbers),
        (vec![2, 2], vec![1.0, 2.0, 3.0, 4.0])
    );
    let select = |indices: &[u32], shape: Vec<u8>| {
        let state = [
            ("a", ch.clone()),
            ("idxs", Two.u32s(&[indices.len()], indices)),
            ("preferred_shape", shape),
        ];
        Two.object("chumpy.reordering", "Select", &state)
    };
    let read = array(Two, &select(&[0, 2], tuple(&[int(2), int(-1)])));
    assert_eq!((read.shape, read.numbers), (vec![2, 1], vec![1.0, 3.0]));
    refused(
        &Two.program(&select(&[0, 4], tuple(&[int(2)]))),
        "not there",
    );
    refused(
        &Two.program(&select(&[0, 1], tuple(&[int(3)]))),
        "does not fit",
    );
    let sum = Two.object("chumpy.ch_ops", "add", &[("a", ch.clone())]);
    refused(&Two.program(&sum), "chumpy.ch_ops.add");
}

#[test]
fn what_is_not_on_the_list_is_named() {
    refused(b"cos\nsystem\n(S'true'\ntR.", "os.system");
    refused(
        &Three.program(&Three.call("builtins", "eval", &[Three.text("1")])),
        "builtins.eval",
    );
    refused(
        &Three.program(&Three.class("numpy.core.multiarray", "fromfile")),
        "fromfile",
    );
    refused(&[0x80, 9, b'N', b'.'], "protocol 9");
    refused(b"Pid\n.", "PERSID");
    refused(&[0x82, 1, b'.'], "EXT1");
    refused(b"\xffN.", "unknown");
}

#[test]
fn broken_programs_are_errors() {
    for (program, hint) in [
        (&b""[..], "announced"),
        (b".", "empty"),
        (b"N", "announced"),
        (b"(0.", "empty"),
        (b"t.", "mark"),
        (b"]Nu.", "mark"),
        (b"}(NNNu.", "without its value"),
        (b"N(Ne.", "plain value"),
        (b"}(Ne.", "no list"),
        (b"h\x05.", "remembered"),
        (b"NNb.", "plain value"),
        (b"NNR.", "no class"),
        (b"I1", "no end"),
        (b"X\xff\xff\xff\x7fab.", "2147483647 bytes are announced"),
        (b"\x8d\xff\xff\xff\xff\xff\xff\xff\xffab.", "are announced"),
        (b"\x8b\xff\xff\xff\x7f.", "announced"),
        (b"\x8a\x09123456789.", "integer of 9 bytes"),
        (b"\x8c\x01\xff.", "UTF-8"),
        (b"}.", "dictionary"),
        (b"N.", "None"),
    ] {
        refused(program, hint);
    }
}

/// Programs whose value would fill any memory, were it built or followed.
#[test]
fn bombs_cost_nothing() {
    // Lists of ten times the list before, a hundred deep.
    let mut laughs = b"]N".to_vec();
    for _ in 0..100 {
        laughs.extend(b"aq\x00](");
        laughs.extend(b"h\x00".repeat(10));
        laughs.extend(b"eN");
    }
    laughs.extend(b"a.");
    refused(&laughs, "neither numbers");
    // An expression of itself.
    let ch = Two.class("chumpy.ch", "Ch");
    let own = [&ch[..], b")\x81q\x00}X\x01\x00\x00\x00xh\x00sb."].concat();
    refused(&own, "too deeply");
    // A shared selection of itself, twice a level.
    let select = Two.class("chumpy.reordering", "Select");
    let state = b")\x81q\x00}(X\x01\x00\x00\x00ah\x00X\x04\x00\x00\x00idxsh\x00ub.";
    refused(&[&select[..], state].concat(), "too deeply");
    refused(
        &[&b"(".repeat(MOST_OPCODES + 1)[..], b"N."].concat(),
        "opcodes",
    );
    // One list of pairs, made a dictionary again and again.
    let pair = b"(NNtq\x01";
    let pairs = [&b"]q\x02("[..], pair, &b"h\x01".repeat(2000), b"e0"].concat();
    let ordered = Three.class("collections", "OrderedDict");
    let again = [&ordered[..], b"(h\x02tR"].concat();
    let program = [pairs, again.repeat(2000), b".".to_vec()].concat();
    refused(&program, "opcodes");
    // A long text, decoded for each number of a list.
    let long = "é".repeat(100_000);
    let element = [Two.element_type("<f8"), b"q\x01".to_vec()].concat();
    let bytes = Two.call(
        "_codecs",
        "encode",
        &[Three.text(&long), Two.text("latin1")],
    );
    let scalar = Two.call("numpy.core.multiarray", "scalar", &[element, bytes]);
    let many = [
        &b"]("[..],
        &scalar,
        b"q\x02",
        &b"h\x02".repeat(60_000),
        b"e.",
    ]
    .concat();
    let start = std::time::Instant::now();
    refused(&many, "neither numbers");
    let names = [
        &b"]("[..],
        &Two.bytes(long.as_bytes()),
        b"q\x02",
        &b"h\x02".repeat(60_000),
        b"e.",
    ]
    .concat();
    refused(&names, "neither numbers");
    assert!(start.elapsed().as_secs() < 2);
    // More numbers than there is room for.
    let large = Two.program(&Two.array("|u1", &[100], false, &[0; 100]));
    assert!(parse_array(&large, 99).unwrap_err().contains("more than"));
}
