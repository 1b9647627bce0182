//! From bytes to JSON and binary chunk (GLB), and from URIs to bytes.

use super::Notes;
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
    /// UTF-8, without byte order mark and padding.
    pub json: Cow<'a, [u8]>,
    pub bin: Option<&'a [u8]>,
    pub is_glb: bool,
}

/// Splits a .glb into its chunks; a .gltf is its own JSON.
pub fn open<'a>(bytes: &'a [u8], notes: &mut Notes) -> Result<Container<'a>> {
    let container = if bytes.starts_with(GLB_MAGIC) {
        open_glb(bytes)?
    } else {
        Container { json: bytes.into(), bin: None, is_glb: false }
    };
    let json = plain_text(container.json, notes)?;
    match json.iter().find(|b| !b.is_ascii_whitespace()) {
        Some(b'{') => Ok(Container { json, ..container }),
        _ if container.is_glb => Ok(Container { json, ..container }),
        Some(_) => Err(Fault::new(Kind::NotGltf, "it starts neither like JSON nor like a .glb")),
        None => Err(Fault::new(Kind::NotGltf, "it is empty")),
    }
}

/// The JSON text as UTF-8, without what some writers put before and after it.
fn plain_text<'a>(json: Cow<'a, [u8]>, notes: &mut Notes) -> Result<Cow<'a, [u8]>> {
    let json = match *json.first_chunk().unwrap_or(&[0; 2]) {
        [0xFF, 0xFE] | [b'{', 0] => Cow::Owned(from_utf16(&json, u16::from_le_bytes, notes)?),
        [0xFE, 0xFF] | [0, b'{'] => Cow::Owned(from_utf16(&json, u16::from_be_bytes, notes)?),
        _ => json,
    };
    let marked = json.starts_with("\u{FEFF}".as_bytes());
    notes.add_if("the JSON begins with a byte order mark, which is skipped", marked);
    let start = if marked { 3 } else { 0 };
    let end = json.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1).max(start);
    notes.add_if("the JSON is padded with zeros in place of spaces", end < json.len() && end > start);
    Ok(match json {
        Cow::Borrowed(json) => Cow::Borrowed(&json[start..end]),
        Cow::Owned(mut json) => {
            json.truncate(end);
            json.drain(..start);
            Cow::Owned(json)
        }
    })
}

fn from_utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16, notes: &mut Notes) -> Result<Vec<u8>> {
    notes.add("the JSON is UTF-16 in place of UTF-8");
    let units: Vec<u16> = bytes.as_chunks().0.iter().map(|pair| unit(*pair)).collect();
    let text = String::from_utf16(&units);
    text.map(String::into_bytes).map_err(|_| Fault::new(Kind::NotGltf, "its UTF-16 is broken; save it as UTF-8"))
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
    json.map(|json| Container { json: json.into(), bin, is_glb: true })
        .ok_or_else(|| bad("the GLB holds no JSON chunk".into()))
}

/// The bytes that `uri` names: a data: URI's own, or a file's through `resolve`.
pub fn fetch(uri: &str, resolve: &Resolver<'_>, notes: &mut Notes) -> Result<Vec<u8>> {
    let uri = uri.trim();
    if uri.get(..5).is_some_and(|s| s.eq_ignore_ascii_case("data:")) {
        return data_uri(&uri[5..], notes);
    }
    if let Some(scheme) = scheme(uri) {
        let what = format!("URI \"{}\": scheme {scheme} is not read; save the file beside the scene", quote(uri));
        return Err(Fault::new(Kind::Unsupported, what));
    }
    let path = percent_decode(uri)?;
    resolve(&path).or_else(|error| elsewhere(uri, &path, resolve, notes).ok_or(error)).map_err(|e| {
        Fault::new(
            Kind::Read,
            format!("cannot read \"{}\": {e}; put the file there or re-export as .glb", quote(&path)),
        )
    })
}

/// The file by the names that it may have where a writer did not follow RFC 3986: back slashes, or % for itself.
fn elsewhere(uri: &str, path: &str, resolve: &Resolver<'_>, notes: &mut Notes) -> Option<Vec<u8>> {
    if path.contains('\\')
        && let Ok(bytes) = resolve(&path.replace('\\', "/"))
    {
        notes.add("back slashes in file names are read as slashes");
        return Some(bytes);
    }
    let bytes = (uri != path).then(|| resolve(uri).ok()).flatten()?;
    notes.add("file names with % are read as they are written");
    Some(bytes)
}

/// `http` of `http://…`; a single letter is a drive of a path, not a scheme.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let fits = scheme.len() > 1 && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b));
    fits.then_some(scheme)
}

/// Decodes the part after `data:`: base64, as glTF says, or else percent-encoded bytes (RFC 2397).
fn data_uri(rest: &str, notes: &mut Notes) -> Result<Vec<u8>> {
    let (head, payload) = rest.split_once(',').ok_or_else(|| Fault::invalid("data URI without a comma"))?;
    let encoding = head.rsplit(';').next().unwrap_or_default().trim();
    let is_base64 = encoding.eq_ignore_ascii_case("base64");
    notes.add_if(
        "data URIs that are not marked as ;base64 in small letters are read all the same",
        encoding != "base64",
    );
    if !is_base64 {
        return Ok(percent_bytes(payload).into_owned());
    }
    let plain = percent_bytes(payload);
    notes.add_if("percent-encoded base64 is decoded", matches!(plain, Cow::Owned(_)));
    let wrapped = plain.iter().any(u8::is_ascii_whitespace);
    notes.add_if("white space in base64 is skipped", wrapped);
    let decoded = match wrapped {
        true => base64(&plain.iter().copied().filter(|c| !c.is_ascii_whitespace()).collect::<Vec<u8>>()),
        false => base64(&plain),
    };
    decoded.ok_or_else(|| Fault::invalid("data URI whose base64 is broken; re-export the file"))
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

/// Undoes %XX escapes of a path.
fn percent_decode(uri: &str) -> Result<Cow<'_, str>> {
    match percent_bytes(uri) {
        Cow::Borrowed(_) => Ok(Cow::Borrowed(uri)),
        Cow::Owned(bytes) => {
            let decoded = String::from_utf8(bytes).ok().filter(|s| !s.contains('\0'));
            decoded.map(Cow::Owned).ok_or_else(|| Fault::invalid(format!("URI \"{}\" is not a path", quote(uri))))
        }
    }
}

/// Undoes %XX escapes. A stray % stays, as writers that forget to escape mean it so.
fn percent_bytes(text: &str) -> Cow<'_, [u8]> {
    let bytes = text.as_bytes();
    if !bytes.contains(&b'%') {
        return Cow::Borrowed(bytes);
    }
    let digit = |at: usize| bytes.get(at).and_then(|b| char::from(*b).to_digit(16));
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        match (bytes[at], digit(at + 1), digit(at + 2)) {
            (b'%', Some(high), Some(low)) => (out.push((high * 16 + low) as u8), at += 3),
            (byte, ..) => (out.push(byte), at += 1),
        };
    }
    Cow::Owned(out)
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
        let mut notes = Notes::default();
        let fault = fetch("https://example.org/a.bin", &none, &mut notes).unwrap_err();
        assert_eq!(fault.kind, Kind::Unsupported);
        assert!(fault.what.contains("https"), "{}", fault.what);
        assert_eq!(fetch("C:/a.bin", &none, &mut notes).unwrap_err().kind, Kind::Read);
    }
}
