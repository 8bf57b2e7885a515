//! Depth inside JPEG files, written here as phones write it.

mod tiny_files;

use base64::Engine;
use defocus::scene::rgbd::{self, DepthEncoding, DepthKind, RgbdScene};
use tiny_files::{png, png16, write};

fn jpeg(width: u32, height: u32, value: impl Fn(u32, u32) -> u8) -> Vec<u8> {
    let image = image::GrayImage::from_fn(width, height, |x, y| image::Luma([value(x, y)]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 100);
    image.write_with_encoder(encoder).expect("encodes");
    bytes.into_inner()
}

/// A segment of an application.
fn segment(marker: u8, content: &[u8]) -> Vec<u8> {
    [&[0xff, marker][..], &(content.len() as u16 + 2).to_be_bytes(), content].concat()
}

fn xmp(text: &str) -> Vec<u8> {
    segment(0xe1, &[b"http://ns.adobe.com/xap/1.0/\0", text.as_bytes()].concat())
}

/// A JPEG with segments behind its first two bytes.
fn with(jpeg: &[u8], segments: &[Vec<u8>]) -> Vec<u8> {
    [&jpeg[..2], &segments.concat(), &jpeg[2..]].concat()
}

fn load_as(bytes: &[u8], encoding: &DepthEncoding) -> Result<RgbdScene, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = write(folder.path(), "phone.jpg", bytes);
    rgbd::load(&path, None, encoding, 0.8).map_err(|e| e.to_string())
}

fn load(bytes: &[u8]) -> RgbdScene {
    load_as(bytes, &DepthEncoding::METRES).unwrap_or_else(|e| panic!("{e}"))
}

/// A picture with GDepth: the map in base64 over several segments of extended XMP.
fn gdepth(map: &[u8], attributes: &str) -> Vec<u8> {
    let data = base64::engine::general_purpose::STANDARD.encode(map);
    let extended = format!("<x:xmpmeta><rdf:RDF><rdf:Description GDepth:Data=\"{data}\"/></rdf:RDF></x:xmpmeta>");
    let main = format!("<x:xmpmeta><rdf:RDF><rdf:Description {attributes}/></rdf:RDF></x:xmpmeta>");
    let mut segments = vec![xmp(&main)];
    // In the order that is not theirs: each says where it belongs.
    let pieces: Vec<(usize, &[u8])> = extended.as_bytes().chunks(100).enumerate().collect();
    for (index, piece) in pieces.iter().rev() {
        let header = [&[b'7'; 32][..], &(extended.len() as u32).to_be_bytes(), &(*index as u32 * 100).to_be_bytes()];
        let content = [&b"http://ns.adobe.com/xmp/extension/\0"[..], &header.concat(), piece].concat();
        segments.push(segment(0xe1, &content));
    }
    with(&jpeg(16, 8, |x, _| 10 * x as u8), &segments)
}

fn near(found: f32, expected: f64) -> bool {
    (f64::from(found) / expected - 1.0).abs() < 1e-3
}

#[test]
fn gdepth_in_both_formats() {
    let map = png16(16, 8, |x, _| if x < 8 { 0 } else { 65535 / 3 });
    let inverse =
        gdepth(&map, r#"GDepth:Format="RangeInverse" GDepth:Near="0.5" GDepth:Far="4.0" GDepth:Mime="image/png""#);
    let scene = load(&inverse);
    // far near / (far - d (far - near)): at a third 2 / (4 - 3.5 / 3).
    assert!(
        near(scene.depth.at(1, 1), 0.5) && near(scene.depth.at(12, 1), 2.0 / (4.0 - 3.5 / 3.0)),
        "{:?}",
        scene.depth
    );
    assert!(scene.notes.iter().any(|note| note.contains("0.5 and 4 metres")), "{:?}", scene.notes);
    let linear = load(&gdepth(&map, "GDepth:Format='RangeLinear' GDepth:Near='0.5' GDepth:Far='3.5'"));
    assert!(near(linear.depth.at(1, 1), 0.5) && near(linear.depth.at(12, 1), 1.5));
    // Along rays: the same wall is nearer along the axis at the border.
    let ray = load(&gdepth(
        &png(16, 8, [0; 3]),
        "GDepth:Format='RangeLinear' GDepth:Near='2' GDepth:Far='4' GDepth:MeasureType='OpticRay'",
    ));
    assert!(ray.depth.at(0, 0) < ray.depth.at(8, 4) && ray.depth.at(8, 4) < 2.0);
    // Half the size is resampled.
    let half = load(&gdepth(&png16(8, 4, |_, _| 0), "GDepth:Format='RangeLinear' GDepth:Near='3' GDepth:Far='4'"));
    assert!(half.depth.pixels.iter().all(|depth| near(*depth, 3.0)));
}

#[test]
fn numbers_without_units_are_asked_for() {
    let file = gdepth(&png16(16, 8, |x, _| 4000 * x as u16), "GDepth:Format='RangeInverse'");
    let error = load_as(&file, &DepthEncoding::METRES).expect_err("no range");
    assert!(error.contains("no units") && error.contains("--depth-range"), "{error}");
    let kind = DepthKind::Relative { near_m: 1.0, far_m: 10.0 };
    let scene = load_as(&file, &DepthEncoding { kind, ..DepthEncoding::METRES }).unwrap_or_else(|e| panic!("{e}"));
    assert!(near(scene.depth.at(15, 1), 1.0) && near(scene.depth.at(0, 1), 10.0), "{:?}", scene.depth);
}

/// A picture with a directory of what lies behind it: a depth map, and something else.
fn dynamic(map: &[u8], units: &str) -> Vec<u8> {
    let other = b"something else";
    let text = format!(
        "<x:xmpmeta><rdf:RDF><rdf:Description><Device:Cameras><rdf:Seq><rdf:li><Camera:DepthMap \
         DepthMap:Format=\"RangeLinear\" DepthMap:Near=\"0.25\" DepthMap:Far=\"2.25\" DepthMap:Units=\"{units}\" \
         DepthMap:DepthURI=\"android/depthmap\"/></rdf:li></rdf:Seq></Device:Cameras>\
         <Container:Directory><rdf:Seq>\
         <rdf:li><Container:Item Item:Mime=\"image/jpeg\" Item:Semantic=\"Primary\"/></rdf:li>\
         <rdf:li><Container:Item><Item:Mime>image/jpeg</Item:Mime><Item:Semantic>Depth</Item:Semantic>\
         <Item:Length>{}</Item:Length></Container:Item></rdf:li>\
         <rdf:li><Container:Item Item:Mime=\"text/plain\" Item:Length=\"{}\"/></rdf:li>\
         </rdf:Seq></Container:Directory></rdf:Description></rdf:RDF></x:xmpmeta>",
        map.len(),
        other.len()
    );
    [&with(&jpeg(16, 8, |x, _| 10 * x as u8), &[xmp(&text)])[..], map, other].concat()
}

#[test]
fn dynamic_depth_in_metres_and_dioptres() {
    let map = jpeg(16, 8, |x, _| if x < 8 { 0 } else { 255 });
    let metres = load(&dynamic(&map, "Meters"));
    assert!(near(metres.depth.at(1, 1), 0.25) && near(metres.depth.at(14, 1), 2.25), "{:?}", metres.depth);
    let dioptres = load(&dynamic(&map, "Diopters"));
    assert!(near(dioptres.depth.at(1, 1), 4.0) && near(dioptres.depth.at(14, 1), 1.0 / 2.25));
}

/// A picture with others behind it, which say themselves what they are.
fn multi_picture(kind: &str) -> Vec<u8> {
    let text = format!(
        "<x:xmpmeta><rdf:RDF><rdf:Description apdi:AuxiliaryImageType='{kind}' apdi:FloatMinValue='0.5' \
         apdi:FloatMaxValue='2.5'/></rdf:RDF></x:xmpmeta>"
    );
    let map = with(&jpeg(8, 4, |x, _| if x < 4 { 0 } else { 255 }), &[xmp(&text)]);
    let picture = jpeg(16, 8, |x, _| 10 * x as u8);
    // Big-endian: header, a directory of one field, two entries.
    let index_bytes = 8 + 2 + 12 + 4 + 32;
    let picture_bytes = picture.len() + 4 + 4 + index_bytes;
    // Offsets count from behind the four bytes of the name.
    let offset = picture_bytes - (2 + 4 + 4);
    let entry = |length: usize, offset: usize| {
        [&[0; 4][..], &(length as u32).to_be_bytes(), &(offset as u32).to_be_bytes(), &[0; 4]].concat()
    };
    let index = [
        &b"MPF\0MM\0*\0\0\0\x08\0\x01"[..],
        &[0xb0, 0x02, 0, 7, 0, 0, 0, 32, 0, 0, 0, 26],
        &[0; 4],
        &entry(picture_bytes, 0),
        &entry(map.len(), offset),
    ]
    .concat();
    let first = with(&picture, &[segment(0xe2, &index)]);
    assert_eq!(first.len(), picture_bytes);
    [first, map].concat()
}

#[test]
fn disparity_behind_the_picture() {
    let scene = load(&multi_picture("disparity"));
    // 0.5 and 2.5 inverse metres.
    assert!(near(scene.depth.at(1, 1), 2.0) && near(scene.depth.at(14, 1), 0.4), "{:?}", scene.depth);
    let depth = load(&multi_picture("depth"));
    assert!(near(depth.depth.at(1, 1), 0.5) && near(depth.depth.at(14, 1), 2.5));
    let other = load_as(&multi_picture("matte"), &DepthEncoding::METRES).expect_err("no depth");
    assert!(other.contains("no depth of its own"), "{other}");
}

#[test]
fn the_map_is_turned_with_the_picture() {
    let tag = [0x12, 0x01, 3, 0, 1, 0, 0, 0, 6, 0, 0, 0];
    let exif = [&b"Exif\0\0II*\0\x08\0\0\0\x01\0"[..], &tag, &[0; 4]].concat();
    // Stored lying: its left half is the upper half of the upright picture.
    let file = gdepth(
        &png16(16, 8, |x, _| if x < 8 { 0 } else { 65535 }),
        "GDepth:Format='RangeLinear' GDepth:Near='1' GDepth:Far='2'",
    );
    let scene = load(&with(&file, &[segment(0xe1, &exif)]));
    assert_eq!((scene.color.size.x, scene.color.size.y), (8, 16));
    assert!(near(scene.depth.at(4, 1), 1.0) && near(scene.depth.at(4, 14), 2.0), "{:?}", scene.depth);
}

#[test]
fn a_jpeg_without_depth_and_damaged_ones() {
    let plain = load_as(&jpeg(16, 8, |x, _| x as u8), &DepthEncoding::METRES).expect_err("no depth");
    assert!(plain.contains("no depth of its own"), "{plain}");
    let map = png16(16, 8, |x, _| 100 * x as u16);
    let files = [
        gdepth(&map, "GDepth:Format='RangeLinear' GDepth:Near='1' GDepth:Far='2'"),
        dynamic(&jpeg(16, 8, |x, _| 9 * x as u8), "Meters"),
        multi_picture("disparity"),
    ];
    for whole in files {
        for at in (0..whole.len()).step_by(2) {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x15;
            if let Err(error) = load_as(&damaged, &DepthEncoding::METRES) {
                assert!(!error.contains('\n'), "{error}");
            }
        }
        for cut in (2..whole.len()).step_by(97) {
            if let Err(error) = load_as(&whole[..cut], &DepthEncoding::METRES) {
                assert!(!error.contains('\n'), "{error}");
            }
        }
    }
    // A directory whose depth map is not in the file.
    let missing = dynamic(&[0; 40], "Meters");
    let error = load_as(&missing, &DepthEncoding::METRES).expect_err("no map");
    assert!(error.contains("not in the file"), "{error}");
}
