//! All bundled cases are read.

use std::path::PathBuf;

use stosszahl_case::CaseFile;

#[test]
fn every_bundled_case_is_read() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../cases");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("the folder of the cases") {
        let path = entry.expect("a file").path();
        // The papers lie in a folder beside.
        if !path.is_file() {
            continue;
        }
        let file = CaseFile::read(&path, &[]);
        if let Err(error) = file {
            panic!("{}", error.report(false));
        }
        count += 1;
    }
    assert!(count >= 36, "{count} cases");
}
