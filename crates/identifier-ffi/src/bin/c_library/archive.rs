//! An archive of one object, as every linker reads it.

/// The archive of an object that defines some symbols.
///
/// The format is that of GNU and System V: a magic, then members. Each member follows a header of 60 characters at an
/// even offset. The first member is the index of symbols, with big-endian numbers of four bytes.
pub(crate) fn of(name: &str, object: &[u8], symbols: &[&str]) -> Vec<u8> {
    const MAGIC: &[u8] = b"!<arch>\n";
    const HEADER: usize = 60;
    let mut index_length = 4 + 4 * symbols.len();
    index_length += symbols.iter().map(|symbol| symbol.len() + 1).sum::<usize>();
    index_length += index_length % 2;
    let place = (MAGIC.len() + HEADER + index_length) as u32;

    let mut index = (symbols.len() as u32).to_be_bytes().to_vec();
    index.extend(symbols.iter().flat_map(|_| place.to_be_bytes()));
    for symbol in symbols {
        index.extend(symbol.bytes().chain([0]));
    }
    index.resize(index_length, 0);

    let mut archive = MAGIC.to_vec();
    for (name, content) in [("/", index.as_slice()), (&format!("{name}/"), object)] {
        let length = content.len();
        // Name, time, owner, group, mode and length: the same for every machine and day.
        let header = format!(
            "{name:<16}{:<12}{:<6}{:<6}{:<8}{length:<10}`\n",
            0, 0, 0, 644
        );
        archive.extend(header.bytes());
        archive.extend(content);
        if length % 2 == 1 {
            archive.push(b'\n');
        }
    }
    archive
}
