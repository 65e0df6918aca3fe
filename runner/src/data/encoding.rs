//! Bytes to text: UTF-8, UTF-16 with or without its mark, and the old single-byte encodings.

use super::error::Problem;
use chardetng::{EncodingDetector, Iso2022JpDetection, Utf8Detection};
use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE};

/// The text, and a note where it was not UTF-8.
///
/// # Errors
/// When it is no text.
pub fn decode(bytes: &[u8]) -> Result<(String, Option<String>), Problem> {
    let encoding = Encoding::for_bom(bytes).map(|(encoding, _)| encoding).or_else(|| wide(bytes));
    let encoding = match encoding {
        Some(encoding) => encoding,
        None if std::str::from_utf8(bytes).is_ok() => UTF_8,
        None => {
            let mut detector = EncodingDetector::new(Iso2022JpDetection::Deny);
            detector.feed(bytes, true);
            detector.guess(None, Utf8Detection::Deny)
        }
    };
    let (text, _, damaged) = encoding.decode(bytes);
    // A table of numbers has no control characters but tabs and ends of lines.
    let is_control = |c: char| c.is_control() && !"\t\r\n\u{c}".contains(c);
    if damaged || text.chars().any(is_control) {
        return Err(Problem::NotText);
    }
    let note = (encoding != UTF_8).then(|| format!("the file is in {}", encoding.name()));
    // Old files end lines with CR alone, some exports double it.
    let text = text.replace("\r\r\n", "\n").replace("\r\n", "\n").replace('\r', "\n");
    Ok((text, note))
}

/// UTF-16 without a mark: every other byte of plain numbers is zero.
fn wide(bytes: &[u8]) -> Option<&'static Encoding> {
    let head = &bytes[..bytes.len().min(1024)];
    let zeros = |odd: usize| head.iter().skip(odd).step_by(2).filter(|b| **b == 0).count();
    let (even, odd, enough) = (zeros(0), zeros(1), head.len() / 4);
    match (even, odd) {
        _ if head.len() < 8 => None,
        (even, odd) if odd > enough && even == 0 => Some(UTF_16LE),
        (even, odd) if even > enough && odd == 0 => Some(UTF_16BE),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "Zeit [s];Weg [µm];Prüfkraft [N]\n0;1;2\n";

    fn utf16(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(bytes).collect()
    }

    #[test]
    fn encodings_are_told_apart() {
        let latin: Vec<u8> = TEXT.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
        let marked = utf16(&format!("\u{feff}{TEXT}"), u16::to_le_bytes);
        let cases = [
            (TEXT.as_bytes().to_vec(), false),
            (format!("\u{feff}{}", TEXT.replace('\n', "\r\n")).into_bytes(), false),
            (latin, true),
            (marked, true),
            (utf16(TEXT, u16::to_le_bytes), true),
            (utf16(TEXT, u16::to_be_bytes), true),
        ];
        for (bytes, noted) in cases {
            let (text, note) = decode(&bytes).unwrap();
            assert_eq!(text, TEXT, "{note:?}");
            assert_eq!(note.is_some(), noted, "{note:?}");
        }
    }

    #[test]
    fn what_is_no_text_is_refused() {
        for bytes in [&b"PK\x03\x04\x00\x00\x00\x01"[..], &[0, 159, 146, 150, 1, 2, 3, 4]] {
            assert_eq!(decode(bytes), Err(Problem::NotText));
        }
    }
}
