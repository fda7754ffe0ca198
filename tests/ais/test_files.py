"""A file is opened by what is in it, whatever its name, packing and encoding."""

import bz2
import gzip
import io
import lzma
import zipfile

import pyarrow as pa
import pytest

from glasshelm.ais.files import MAX_LINE_BYTES, TextFile, read_document
from glasshelm.ais.reading import kind_of
from glasshelm.core.errors import InputError

TEXT = "t,mmsi,name\n1,2,BLÅBÆR\n3,4,ØST\n"


def zipped(**files):
    room = io.BytesIO()
    with zipfile.ZipFile(room, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return room.getvalue()


def zstd(data):
    return pa.compress(data, codec="zstd", asbytes=True)


def put(tmp_path, data, name="file"):
    path = tmp_path / name
    path.write_bytes(data)
    return path


def text_of(path):
    with TextFile(path) as file:
        return b"".join(file.blocks()).decode(), file.notes


PACKED = {
    "plain": TEXT.encode(),
    "gzip": gzip.compress(TEXT.encode()),
    "gzip of two parts": gzip.compress(TEXT[:12].encode()) + gzip.compress(TEXT[12:].encode()),
    "bzip2": bz2.compress(TEXT.encode()),
    "xz": lzma.compress(TEXT.encode()),
    "zstd": zstd(TEXT.encode()),
    "zip": zipped(**{"AIS.csv": TEXT}),
    "zip with what comes with it": zipped(**{"a.csv": TEXT, "README.txt": "x", "meta.xml": "x"}),
    "gzip in zip": zipped(**{"a.csv.gz": gzip.compress(TEXT.encode())}),
    "gzip in gzip": gzip.compress(gzip.compress(TEXT.encode())),
    "zstd in gzip": gzip.compress(zstd(TEXT.encode())),
}
ENCODED = {
    "BOM": TEXT.encode("utf-8-sig"),
    "UTF-16 with its mark": TEXT.encode("utf-16"),
    "UTF-16 LE": TEXT.encode("utf-16-le"),
    "UTF-16 BE": TEXT.encode("utf-16-be"),
    "UTF-32": TEXT.encode("utf-32"),
    "Latin-1": TEXT.encode("latin-1"),
    "CR LF": TEXT.replace("\n", "\r\n").encode(),
    "CR": TEXT.replace("\n", "\r").encode(),
    "zeros": TEXT.replace(",", ",\0").encode(),
    "no end": TEXT.rstrip().encode(),
    "UTF-16 in gzip": gzip.compress(TEXT.encode("utf-16")),
}


@pytest.mark.parametrize("data", [*PACKED.values(), *ENCODED.values()], ids=[*PACKED, *ENCODED])
@pytest.mark.parametrize("name", ["file", "T.CSV.GZ", "x.parquet"])
def test_text_is_read_whatever_its_packing_encoding_and_name(tmp_path, data, name):
    assert text_of(put(tmp_path, data, name)) == (TEXT, [])
    assert kind_of(put(tmp_path, data, name)) == "table"


@pytest.mark.slow
@pytest.mark.parametrize("pack", [gzip.compress, bz2.compress, lzma.compress, zstd])
def test_what_is_cut_off_is_read_as_far_as_it_goes(tmp_path, pack):
    # Lines that cannot be packed to nothing; a torn last line is left out.
    whole = "".join(f"{i},{(i * 7919) % 1_000_003}\n" for i in range(120_000))
    path = put(tmp_path, pack(whole.encode())[:-20_000])
    text, (note,) = text_of(path)
    assert len(text) > 100_000
    assert whole.startswith(text)
    assert text.endswith("\n")
    assert "cut off or damaged" in note


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "nothing is in it"),
        (b"\n \n", "nothing is in it"),
        (gzip.compress(b"a,b\n" * 9)[:12], "cut off or damaged"),
        (b"\x28\xb5\x2f\xfd" + bytes(60), "zstd file, cut off or damaged"),
        (zipped(**{"a.csv": TEXT})[:60], "zip archive that is cut off"),
        (zipped(**{"a.csv": TEXT, "b.csv": TEXT}), r"2 files in it \(a.csv, b.csv\)"),
        (zipped(**{"[Content_Types].xml": "x", "xl/workbook.xml": "x"}), "Excel or Word"),
        (zipped(), "an empty zip archive"),
        (zipped(**{"readme.txt": "x"}), "no table in it"),
        (gzip.compress(zipped(**{"a.csv": TEXT})), "a zip archive in a gzip file"),
        (gzip.compress(b"PAR1"), "a Parquet table in a gzip file"),
        (b"7z\xbc\xaf\x27\x1c" + bytes(99), "a 7z archive: unpack it first"),
        (b"Rar!\x1a\x07" + bytes(99), "a RAR archive"),
        (b"a".ljust(257, b"\0") + b"ustar", "a tar archive"),
        (b"%PDF-1.7 ...", "a PDF document: give a table of AIS"),
        (b"SQLite format 3\x00" + bytes(99), "an SQLite database"),
        (b"\xd0\xcf\x11\xe0" + bytes(99), "Excel or Word"),
        (b"<!DOCTYPE html><html><p>404", "an HTML page"),
        (b"<?xml version='1.0'?><gpx/>", "an XML document"),
        (bytes(range(1, 32)) * 40, "neither text nor a kind of file that is known"),
        (b"hello\nworld\n", "neither a table .* nor NMEA 0183 .*begins with 'hello'"),
    ],
    ids=range(21),
)
def test_what_cannot_be_read_is_named_in_one_line(tmp_path, data, says):
    with pytest.raises(InputError, match=says) as error:
        kind_of(put(tmp_path, data, "traffic.nmea"))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("!AIVDM,1,1,,A,x,0*00", "nmea"),
        ("\\c:1*00\\!BSVDM,1,1,,A,x,0*00", "nmea"),
        ("2024-06-01 12:00:00,!AIVDM,1,1,,A,x,0*00", "nmea"),
        ("# a logger's remark\n$GPRMC,1", "nmea"),
        ("mmsi;time;lat;lon", "table"),
        ("a,b,c", "table"),
        ('time,mmsi,raw\n1,2,"!AIVDM,1,1,,A,x,0*00"', "table"),
        (' {"ownShip": {}}', "json"),
        ("[1]", "json"),
    ],
)
def test_what_a_text_is(tmp_path, text, kind):
    assert kind_of(put(tmp_path, text.encode())) == kind


@pytest.mark.parametrize("length", [3 * MAX_LINE_BYTES, 3_000_000])
def test_an_endless_line_costs_itself_alone(tmp_path, length):
    data = b"a\n" + b"x" * length + b"\nb\n" + b"y" * length
    with TextFile(put(tmp_path, data)) as file:
        lines = list(file.lines())
    assert [line for line in lines if len(line) == 1] == [b"a", b"b"]
    assert max(map(len, lines)) < 2**20


@pytest.mark.parametrize("there", [False, True])
def test_what_is_no_file(tmp_path, there):
    with pytest.raises(InputError, match="cannot be read"):
        TextFile(tmp_path if there else tmp_path / "none")


def test_a_document_is_read_whole(tmp_path):
    for data in (TEXT.encode("utf-8-sig"), gzip.compress(TEXT.encode("utf-16"))):
        assert read_document(put(tmp_path, data)).decode() == TEXT
    with pytest.raises(InputError, match="longer than 16 MB"):
        read_document(put(tmp_path, gzip.compress(bytes(17_000_000))))
