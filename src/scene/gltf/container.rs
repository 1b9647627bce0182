//! From bytes to JSON and binary chunk (GLB), and from URIs to bytes.

use super::error::{Fault, Kind, Result, quote};
use std::borrow::Cow;
use std::io;

/// Finds the bytes of a file that a scene names by a relative path (already percent-decoded).
pub type Resolver<'a> = dyn Fn(&str) -> io::Result<Vec<u8>> + 'a;

const GLB_MAGIC: &[u8; 4] = b"glTF";
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;

/// A file's JSON text and, of a GLB, its binary chunk.
pub struct Container<'a> {
    pub json: &'a [u8],
    pub bin: Option<&'a [u8]>,
    pub is_glb: bool,
}

/// Splits a .glb into its chunks; a .gltf is its own JSON.
pub fn open(bytes: &[u8]) -> Result<Container<'_>> {
    if bytes.starts_with(GLB_MAGIC) {
        return open_glb(bytes);
    }
    match bytes.iter().find(|b| !b.is_ascii_whitespace()) {
        Some(b'{') => Ok(Container { json: bytes, bin: None, is_glb: false }),
        Some(_) => Err(Fault::new(Kind::NotGltf, "it starts neither like JSON nor like a .glb")),
        None => Err(Fault::new(Kind::NotGltf, "it is empty")),
    }
}

fn open_glb(bytes: &[u8]) -> Result<Container<'_>> {
    let bad = |what: String| Fault::new(Kind::NotGltf, what);
    let word = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(bad("the GLB header is cut short".into()));
    };
    if version != 2 {
        return Err(bad(format!("GLB version {version}; convert it to version 2")));
    }
    let length = length as usize;
    if length > bytes.len() {
        return Err(bad(format!("the GLB is cut short: it says {length} bytes and has {}", bytes.len())));
    }
    let (mut at, mut json, mut bin) = (12, None, None);
    while at < length {
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else {
            return Err(bad("a GLB chunk header is cut short".into()));
        };
        let start = at + 8;
        let Some(data) =
            start.checked_add(size as usize).filter(|end| *end <= length).and_then(|e| bytes.get(start..e))
        else {
            return Err(bad(format!("the GLB chunk at byte {at} is cut short: it says {size} bytes")));
        };
        match (kind, json) {
            (CHUNK_JSON, None) => json = Some(data),
            (_, None) => return Err(bad("the first GLB chunk is not JSON".into())),
            (CHUNK_BIN, Some(_)) if bin.is_none() => bin = Some(data),
            _ => {}
        }
        at = start + (size as usize).next_multiple_of(4);
    }
    json.map(|json| Container { json, bin, is_glb: true }).ok_or_else(|| bad("the GLB holds no JSON chunk".into()))
}

/// The bytes that `uri` names: a data: URI's own, or a file's through `resolve`.
pub fn fetch(uri: &str, resolve: &Resolver<'_>) -> Result<Vec<u8>> {
    if uri.get(..5).is_some_and(|s| s.eq_ignore_ascii_case("data:")) {
        return data_uri(&uri[5..]);
    }
    if let Some(scheme) = scheme(uri) {
        let what = format!("URI \"{}\": scheme {scheme} is not read; save the file beside the scene", quote(uri));
        return Err(Fault::new(Kind::Unsupported, what));
    }
    let path = percent_decode(uri)?;
    resolve(&path).map_err(|e| Fault::new(Kind::Read, format!("cannot read \"{}\": {e}", quote(&path))))
}

/// `http` of `http://…`; a single letter is a drive of a path, not a scheme.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let fits = scheme.len() > 1 && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b));
    fits.then_some(scheme)
}

/// Decodes the part after `data:`; only base64, as glTF says.
fn data_uri(rest: &str) -> Result<Vec<u8>> {
    let (head, payload) = rest.split_once(',').ok_or_else(|| Fault::invalid("data URI without a comma"))?;
    if !head.ends_with(";base64") {
        return Err(Fault::invalid("data URI that is not base64"));
    }
    base64(payload.as_bytes()).ok_or_else(|| Fault::invalid("data URI whose base64 is broken"))
}

/// RFC 4648 base64, padding optional.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let text = text.strip_suffix(b"==").or_else(|| text.strip_suffix(b"=")).unwrap_or(text);
    if text.len() % 4 == 1 {
        return None;
    }
    let mut out = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for quad in text.chunks(4) {
        let mut bits = 0u32;
        for &c in quad {
            bits = bits << 6 | u32::from(sextet(c)?);
        }
        bits <<= 6 * (4 - quad.len());
        out.extend_from_slice(&bits.to_be_bytes()[1..quad.len()]);
    }
    Some(out)
}

fn sextet(c: u8) -> Option<u8> {
    Some(match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' | b'-' => 62,
        b'/' | b'_' => 63,
        _ => return None,
    })
}

/// Undoes %XX escapes. A stray % stays, as writers that forget to escape mean it so.
fn percent_decode(uri: &str) -> Result<Cow<'_, str>> {
    if !uri.contains('%') {
        return Ok(Cow::Borrowed(uri));
    }
    let bytes = uri.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let escape = bytes.get(at + 1..at + 3).and_then(|hex| {
            let hex = std::str::from_utf8(hex).ok().filter(|h| h.bytes().all(|b| b.is_ascii_hexdigit()))?;
            u8::from_str_radix(hex, 16).ok()
        });
        match (bytes[at], escape) {
            (b'%', Some(byte)) => (out.push(byte), at += 3),
            (byte, _) => (out.push(byte), at += 1),
        };
    }
    let decoded = String::from_utf8(out).ok().filter(|s| !s.contains('\0'));
    decoded.map(Cow::Owned).ok_or_else(|| Fault::invalid(format!("URI \"{}\" is not a path", quote(uri))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_matches_rfc_4648() {
        let cases: [(&str, &[u8]); 7] = [
            ("", b""),
            ("Zg==", b"f"),
            ("Zm8=", b"fo"),
            ("Zm9v", b"foo"),
            ("Zm9vYg==", b"foob"),
            ("Zm9vYmE=", b"fooba"),
            ("Zm9vYmFy", b"foobar"),
        ];
        for (text, bytes) in cases {
            assert_eq!(base64(text.as_bytes()).as_deref(), Some(bytes), "{text}");
        }
        assert_eq!(base64(b"Zg"), Some(b"f".to_vec()), "padding is optional");
        assert_eq!(base64(b"Z"), None);
        assert_eq!(base64(b"Zm9v Zg="), None);
    }

    #[test]
    fn percent_escapes_are_undone() {
        assert_eq!(percent_decode("a%20b%C3%A9.bin").unwrap(), "a bé.bin");
        assert_eq!(percent_decode("100%.bin").unwrap(), "100%.bin");
        assert_eq!(percent_decode("%+1.bin").unwrap(), "%+1.bin");
        assert!(percent_decode("%ff.bin").is_err());
        assert!(percent_decode("%00").is_err());
    }

    #[test]
    fn network_uris_are_refused_and_drive_letters_are_not() {
        let none = |_: &str| Err(io::Error::from(io::ErrorKind::NotFound));
        let fault = fetch("https://example.org/a.bin", &none).unwrap_err();
        assert_eq!(fault.kind, Kind::Unsupported);
        assert!(fault.what.contains("https"), "{}", fault.what);
        assert_eq!(fetch("C:/a.bin", &none).unwrap_err().kind, Kind::Read);
    }
}
