use super::*;

fn origin() -> Origin {
    let pair = |name: &str, value: &str| (name.to_owned(), value.to_owned());
    Origin {
        program: ["1.2.3".into(), "abc".into()],
        name: "room".into(),
        scene: vec![pair("geometry", "1"), pair("light", "2")],
        settings: vec![pair("--accuracy", "0.3"), pair("--seed", "0")],
    }
}

/// Records whose values are all different, some of them not finite.
fn records(count: u32, shape: Shape) -> Stored {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state
    };
    let words = (0..count as usize * shape.words()).map(|_| next()).collect();
    let horizons = (0..count as usize * shape.horizon_bytes()).map(|i| (i / 24) as u8 ^ (next() >> 30) as u8).collect();
    Stored { shape, words, horizons }
}

fn shapes() -> [Shape; 3] {
    let horizon = |size| Some(Horizon { size });
    [
        Shape { payloads: 1, horizon: None },
        Shape { payloads: 2, horizon: horizon(8) },
        Shape { payloads: 1, horizon: horizon(64) },
    ]
}

fn why(bytes: &[u8]) -> String {
    parse(bytes, &origin()).unwrap_err()
}

fn written(stored: &Stored) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.records");
    write(&path, &origin(), stored).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn records_come_back_bit_by_bit() {
    for shape in shapes() {
        for count in [0, 1, 1024, 2500] {
            let stored = records(count, shape);
            let bytes = written(&stored);
            assert_eq!(written(&stored), bytes, "the same bytes each time");
            assert!(parse(&bytes, &origin()).unwrap() == stored, "{count} of {shape:?}");
        }
    }
}

#[test]
fn a_flipped_bit_anywhere_and_a_cut_anywhere_are_noticed() {
    let bytes = written(&records(1030, Shape { payloads: 1, horizon: None }));
    let step = (bytes.len() / 500).max(1);
    let places = (0..700.min(bytes.len())).chain((700..bytes.len()).step_by(step));
    for place in places {
        let mut flipped = bytes.clone();
        flipped[place] ^= 1 << (place % 8);
        why(&flipped);
        why(&bytes[..place]);
    }
    assert!(why(&bytes[..bytes.len() - 1]).contains("it ends in block 2 of 2"), "{}", why(&bytes[..bytes.len() - 1]));
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(why(&longer).contains("goes on after its last record"));
    let mut flipped = bytes.clone();
    *flipped.last_mut().unwrap() ^= 4;
    assert!(why(&flipped).contains("damaged: there is another checksum in block 2 of 2"), "{}", why(&flipped));
}

#[test]
fn foreign_files_formats_and_orders_of_bytes_are_named() {
    let bytes = written(&records(3, shapes()[0]));
    let changed = |at: usize, with: &[u8]| {
        let mut other = bytes.clone();
        other[at..at + with.len()].copy_from_slice(with);
        why(&other)
    };
    assert!(why(b"").contains("no file of records"));
    assert!(changed(0, b"hemispan").contains("no file of records"));
    assert!(changed(8, &[1, 2, 3, 4]).contains("byte order"));
    assert!(changed(12, &[9, 0, 0, 0]).contains("version 9 of the format, and this hemicube reads version 1"));
    assert!(changed(40, b"?").contains("header does not fit"));
}

#[test]
fn what_differs_is_named() {
    let bytes = written(&records(3, shapes()[0]));
    let against = |change: &dyn Fn(&mut Origin)| {
        let mut ours = origin();
        change(&mut ours);
        parse(&bytes, &ours).unwrap_err()
    };
    let says =
        |words: &str, change: &dyn Fn(&mut Origin)| assert!(against(change).contains(words), "{}", against(change));
    says("made by hemicube 1.2.3, and this is 1.3.0", &|o| o.program[0] = "1.3.0".into());
    says("other shaders", &|o| o.program[1] = "abd".into());
    says("another geometry than the scene's", &|o| o.scene[0].1 = "7".into());
    says("another light than the scene's, of the scene \"room\"", &|o| {
        o.scene[1].1 = "7".into();
        o.name = "hall".into();
    });
    says("made with --accuracy 0.3, and this run has --accuracy 0.2", &|o| o.settings[0].1 = "0.2".into());
    says("made of something else", &|o| drop(o.settings.pop()));
}

#[test]
fn a_file_that_grows_is_the_file_of_all_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.records");
    let shape = shapes()[1];
    let mut packed = Packed::default();
    for count in [0, 10, 1024, 1030, 3000, 3000] {
        let stored = records(3000, shape);
        let (words, bytes) = (count * shape.words(), count * shape.horizon_bytes());
        let stored =
            Stored { shape, words: stored.words[..words].to_vec(), horizons: stored.horizons[..bytes].to_vec() };
        packed.write(&path, &origin(), &stored).unwrap();
        assert!(std::fs::read(&path).unwrap() == written(&stored), "{count}");
    }
}
