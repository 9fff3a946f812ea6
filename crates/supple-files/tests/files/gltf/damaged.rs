//! Files that were cut or changed at random: never a panic.

use super::malformed::{read, refused, rich};
use serde_json::{Value, json};
use supple::Error;
use supple::internal::math::Random;

/// Down a random path from `at`, by more than `depth` if it goes on.
pub fn somewhere_in<'a>(mut at: &'a mut Value, depth: usize, random: &mut Random) -> &'a mut Value {
    for gone in 0.. {
        let count = at.as_array().map_or(0, Vec::len) + at.as_object().map_or(0, |o| o.len());
        if count == 0 || (gone > depth && random.index(9) == 0) {
            break;
        }
        let k = random.index(count);
        at = match at {
            Value::Array(list) => &mut list[k],
            Value::Object(map) => map.values_mut().nth(k).unwrap(),
            _ => unreachable!(),
        };
    }
    at
}

#[test]
fn containers_and_buffers() {
    let sound = rich();
    let glb = sound.glb();
    for length in [0, 3, 4, 8, 11, 12, 19, 20, 40, glb.len() / 2, glb.len() - 1] {
        let error = read(&glb[..length]).unwrap_err();
        assert!(matches!(error, Error::Format { .. }), "{length}: {error}");
    }
    let mut version = glb.clone();
    version[4] = 3;
    refused(&version, &["GLB", "version 3"]);
    refused(b"{}", &["JSON"]);
    refused(&sound.text("data:;base64,AA!A"), &["buffers[0]", "base64"]);
    refused(
        &sound.text("data:;base64,AAAA"),
        &["buffers[0]", "3 bytes of"],
    );
    refused(&sound.text("data:text/plain,abc"), &["base64"]);
    refused(&sound.text("../../etc/passwd"), &["buffers[0]", "folder"]);
    refused(&sound.text("/etc/passwd"), &["buffers[0]", "folder"]);
    refused(
        &sound.text("https://example.org/a.bin"),
        &["buffers[0]", "folder"],
    );
    refused(&sound.text("a%zz.bin"), &["escape"]);
    refused(
        &sound.text("not-there.bin"),
        &["buffers[0]", "not-there.bin"],
    );
}

#[test]
fn flipped_bits_and_cut_files_never_panic() {
    let glb = rich().glb();
    let mut random = Random::new(77);
    let mut read_well = 0;
    for round in 0..3000 {
        let mut bytes = glb.clone();
        for _ in 0..1 + round % 4 {
            let at = random.index(bytes.len());
            bytes[at] ^= 1 << random.index(8);
        }
        if round % 8 == 0 {
            bytes.truncate(random.index(bytes.len()));
        }
        match read(&bytes) {
            Ok(()) => read_well += 1,
            Err(Error::Format { .. } | Error::Invalid { .. }) => {}
            Err(other) => panic!("{other}"),
        }
    }
    assert!((100..2900).contains(&read_well), "{read_well}");
}

#[test]
fn numbers_of_the_document_may_be_anything() {
    let sound = rich();
    let mut random = Random::new(78);
    let strange = [
        json!(-1),
        json!(0),
        json!(1),
        json!(3),
        json!(1e300),
        json!(u64::MAX),
        json!(0.5),
        json!(null),
        json!("x"),
        json!([]),
        json!({}),
        json!(4_294_967_296u64),
    ];
    for _ in 0..3000 {
        let mut file = sound.clone();
        let at = somewhere_in(&mut file.json, 0, &mut random);
        *at = strange[random.index(strange.len())].clone();
        let _ = read(&file.glb());
    }
}
