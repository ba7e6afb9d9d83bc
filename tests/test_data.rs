// Data that are not part of the repository, for tests that are ignored by name:
//     #[ignore = "needs PROTOMER_TEST_DATA: FOLDER"]
// `test.sh` runs all of them where the variable names the root of the data. Included by `#[path]`.

/// A folder, or a file, of these data.
///
/// Panics where it is absent: a test that was requested must not pass without having compared
/// anything.
pub(crate) fn test_data(name: &str) -> std::path::PathBuf {
    let root = std::env::var_os("PROTOMER_TEST_DATA").unwrap_or_default();
    assert!(
        !root.is_empty(),
        "PROTOMER_TEST_DATA must name the folder of the data that this test needs"
    );
    let path = std::path::Path::new(&root).join(name);
    assert!(path.exists(), "{} is absent", path.display());
    path
}
