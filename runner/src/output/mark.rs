//! The mark that every file of poropunch's carries: what has it may be replaced by poropunch, nothing else may.
//!
//! | kind | mark |
//! |---|---|
//! | CSV and plain text | first line `# written by poropunch VERSION` |
//! | JSON | first field `"written_by": "poropunch VERSION"` |
//! | HTML, SVG, PVD, Markdown | `<!-- written by poropunch VERSION -->` in front, after a doctype or an XML declaration |
//! | manual page | first line `.\" written by poropunch VERSION` |
//! | FMU | comment of the zip archive, at its end |
//! | Parquet | `created_by` of its metadata; its writer puts it there |

use parquet::file::reader::{FileReader, SerializedFileReader};
use std::borrow::Cow;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// What the mark says without its version.
const WORDS: &str = "written by poropunch ";
/// The same in JSON.
const FIELD: &str = "\"written_by\": \"poropunch ";
/// A comment in a manual page.
const ROFF: &str = ".\\\" ";
/// How a Parquet file begins.
const PARQUET: &[u8] = b"PAR1";
/// Bytes at the beginning and at the end of a file in which its mark stands.
const REACH: usize = 256;

/// The mark in words, for comments of other formats.
pub fn words() -> String {
    format!("{WORDS}{}", env!("CARGO_PKG_VERSION"))
}

/// The contents of a file with their mark, in the way of the file's kind (its extension).
pub fn marked<'a>(file: &Path, contents: &'a [u8]) -> Cow<'a, [u8]> {
    if is_marked(contents) {
        return Cow::Borrowed(contents);
    }
    let kind = file.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let with =
        |at: usize, mark: &str| Cow::Owned([&contents[..at], mark.as_bytes(), &contents[at..]].concat());
    match kind.as_str() {
        "json" => match contents {
            // One field on a line of its own, or in front of the others.
            [b'{', b'\n', ..] => with(1, &format!("\n  {FIELD}{}\",", env!("CARGO_PKG_VERSION"))),
            [b'{', b'}', ..] => with(1, &format!("{FIELD}{}\"", env!("CARGO_PKG_VERSION"))),
            [b'{', ..] => with(1, &format!("{FIELD}{}\",", env!("CARGO_PKG_VERSION"))),
            _ => Cow::Borrowed(contents),
        },
        "html" | "svg" | "md" | "pvd" => with(prolog(contents), &format!("<!-- {} -->\n", words())),
        "1" => with(0, &format!("{ROFF}{}\n", words())),
        "parquet" => Cow::Borrowed(contents),
        _ => with(0, &format!("# {}\n", words())),
    }
}

/// Length of a doctype or an XML declaration at the beginning.
fn prolog(contents: &[u8]) -> usize {
    if !contents.starts_with(b"<!DOCTYPE") && !contents.starts_with(b"<?xml") {
        return 0;
    }
    contents.iter().position(|b| *b == b'>').map_or(0, |end| end + 1)
}

/// Whether contents carry the mark.
pub fn is_marked(contents: &[u8]) -> bool {
    let head = &contents[..contents.len().min(REACH)];
    let tail = &contents[contents.len().saturating_sub(REACH)..];
    is_mark(head, tail)
}

/// Whether a file carries the mark.
///
/// # Errors
/// When it cannot be read.
pub fn has_mark(file: &Path) -> std::io::Result<bool> {
    let mut file = File::open(file)?;
    let mut head = Vec::with_capacity(REACH);
    file.by_ref().take(REACH as u64).read_to_end(&mut head)?;
    if head.starts_with(PARQUET) {
        let read = SerializedFileReader::new(file).map_err(std::io::Error::other)?;
        return Ok(read.metadata().file_metadata().created_by().is_some_and(|by| by.starts_with(WORDS)));
    }
    let length = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(length.saturating_sub(REACH as u64)))?;
    let mut tail = Vec::with_capacity(REACH);
    file.read_to_end(&mut tail)?;
    Ok(is_mark(&head, &tail))
}

/// Only where the mark belongs: a measurement may well tell that it was made from a file with the mark.
fn is_mark(head: &[u8], tail: &[u8]) -> bool {
    let head = String::from_utf8_lossy(head);
    if head.starts_with("PK") {
        return String::from_utf8_lossy(tail).rfind(WORDS).is_some();
    }
    let comment = format!("<!-- {WORDS}");
    let starts = |text: &str, mark: &str| text.trim_start().starts_with(mark);
    let after_prolog = head.get(prolog(head.as_bytes())..).unwrap_or("");
    let first_field = head.strip_prefix('{').unwrap_or("");
    let comments = ["# ", ROFF].map(|comment| format!("{comment}{WORDS}"));
    comments.iter().any(|c| head.starts_with(c))
        || starts(after_prolog, &comment)
        || starts(first_field, FIELD)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_marked_once_and_recognised() {
        let cases: [(&str, &[u8]); 9] = [
            ("a.1", b".TH a\n"),
            ("a.csv", b"time_s\n1\n"),
            ("a.json", b"{\n  \"x\": 1\n}"),
            ("a.json", b"{\"x\":1}"),
            ("a.json", b"{}"),
            ("a.html", b"<!DOCTYPE html><html></html>"),
            ("a.svg", b"<svg/>"),
            ("a.svg", b"<?xml version=\"1.0\"?><svg/>"),
            ("a.blake3", b"00ff\n"),
        ];
        for (name, contents) in cases {
            let once = marked(Path::new(name), contents).into_owned();
            assert!(!is_marked(contents) && is_marked(&once), "{name}");
            assert_eq!(marked(Path::new(name), &once), once, "{name}");
            if name.ends_with("json") {
                let value: serde_json::Value = serde_json::from_slice(&once).unwrap();
                assert!(value["written_by"].as_str().unwrap().starts_with("poropunch"), "{value}");
            }
            let d = tempfile::tempdir().unwrap();
            std::fs::write(d.path().join(name), &once).unwrap();
            assert!(has_mark(&d.path().join(name)).unwrap(), "{name}");
        }
    }

    #[test]
    fn a_file_that_only_mentions_the_mark_has_none() {
        for text in
            ["# resampled from a file written by poropunch 0.1.0\n", "a\n# written by poropunch 0.1.0\n", ""]
        {
            assert!(!is_marked(text.as_bytes()), "{text}");
        }
    }
}
