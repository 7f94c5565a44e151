//! What is done with decoded attributes, element by element.

use std::f32::consts::FRAC_1_SQRT_2;

/// Four signed numbers of 8 or 16 bits, by the length of the element.
fn signed(element: &[u8]) -> [i32; 4] {
    match *element {
        [a, b, c, d] => [a, b, c, d].map(|v| i32::from(v as i8)),
        [a, b, c, d, e, f, g, h] => [[a, b], [c, d], [e, f], [g, h]].map(|v| i32::from(i16::from_le_bytes(v))),
        _ => [0; 4],
    }
}

/// Writes the low bits of four numbers into an element of 4 or 8 bytes.
fn store(element: &mut [u8], values: [i32; 4]) {
    let size = element.len() / 4;
    for (to, value) in element.chunks_exact_mut(size).zip(values) {
        to.copy_from_slice(&value.to_le_bytes()[..size]);
    }
}

/// Filter 1: unit vectors from the octahedron, to signed normalized integers of the same size.
pub(super) fn octahedral(bytes: &mut [u8], stride: usize) {
    let most = if stride == 4 { 127.0 } else { 32_767.0 };
    for element in bytes.chunks_exact_mut(stride) {
        let [x, y, one, rest] = signed(element);
        let (x, y) = (x as f32 / one as f32, y as f32 / one as f32);
        let z = 1.0 - x.abs() - y.abs();
        // The lower half is folded over the edges of the upper.
        let fold = z.min(0.0);
        let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
        let scale = most / (x * x + y * y + z * z).sqrt();
        store(element, [(x * scale).round() as i32, (y * scale).round() as i32, (z * scale).round() as i32, rest]);
    }
}

/// Filter 2: unit quaternions without their greatest component, to signed normalized integers of 16 bits.
pub(super) fn quaternion(bytes: &mut [u8]) {
    for element in bytes.chunks_exact_mut(8) {
        let [x, y, z, last] = signed(element);
        let one = (last | 3) as f32;
        let [x, y, z] = [x, y, z].map(|v| v as f32 / one * FRAC_1_SQRT_2);
        let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
        let mut values = [0; 4];
        for (i, value) in [w, x, y, z].into_iter().enumerate() {
            values[((last & 3) as usize + i) % 4] = (value * 32_767.0).round() as i32;
        }
        store(element, values);
    }
}

/// Filter 3: numbers of 24 bits with an exponent of 8, to floats.
pub(super) fn exponential(bytes: &mut [u8]) {
    for number in bytes.as_chunks_mut::<4>().0 {
        let stored = i32::from_le_bytes(*number);
        let (exponent, mantissa) = (stored >> 24, stored << 8 >> 8);
        *number = ((f64::from(mantissa) * libm::exp2(f64::from(exponent))) as f32).to_le_bytes();
    }
}

/// Filter 4: luminance and two colour differences, to unsigned normalized red, green, blue and alpha of the same size.
pub(super) fn color(bytes: &mut [u8], stride: usize) {
    let bits = 8 * (stride / 4) as u32;
    let mask = (1 << bits) - 1;
    for element in bytes.chunks_exact_mut(stride) {
        let [y, co, cg, alpha] = signed(element);
        let (y, alpha) = (y & mask, alpha & mask);
        // The highest bit of alpha tells how many bits there are.
        let most = (1i32 << (32 - alpha.leading_zeros())) - 1;
        let alpha = alpha & (most >> 1);
        let alpha = alpha << 1 | alpha & 1;
        let scale = mask as f32 / most as f32;
        store(
            element,
            [y + co - cg, y + cg, y - co - cg, alpha].map(|v| ((v as f32 * scale).round() as i32).clamp(0, mask)),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shorts(values: &[i16]) -> Vec<u8> {
        values.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    #[test]
    fn octahedral_vectors_come_back() {
        for stride in [4, 8] {
            let most = if stride == 4 { 127.0 } else { 32_767.0 };
            // With 7 and with 12 bits a number.
            let one: i32 = if stride == 4 { 63 } else { 2047 };
            for [x, y, z] in [[0.0, 0.0, 1.0], [0.6, 0.0, -0.8], [-0.36, 0.48, 0.8], [-0.36, -0.48, -0.8f64]] {
                let sum = x.abs() + y.abs() + z.abs();
                let (mut u, mut v) = (x / sum, y / sum);
                if z < 0.0 {
                    (u, v) = ((1.0 - v.abs()) * 1f64.copysign(u), (1.0 - u.abs()) * 1f64.copysign(v));
                }
                let stored = [(u * f64::from(one)).round() as i32, (v * f64::from(one)).round() as i32, one, -5];
                let mut element = vec![0; stride];
                store(&mut element, stored);
                octahedral(&mut element, stride);
                let [a, b, c, rest] = signed(&element);
                let error = [f64::from(a) / most - x, f64::from(b) / most - y, f64::from(c) / most - z];
                assert!(error.iter().all(|e| e.abs() < 2.0 / f64::from(one)), "{error:?}");
                assert_eq!(rest, -5);
            }
        }
    }

    #[test]
    fn quaternions_come_back() {
        // A turn by 90 degrees about y, whose greatest component can be said to be the last or the second.
        for greatest in [1, 3] {
            // The other of the two is so many places after the greatest.
            let place = 1;
            let mut stored = [0, 0, 0, (2047 & !3) | greatest];
            stored[place] = 2047;
            let mut element = shorts(&stored);
            quaternion(&mut element);
            let values = signed(&element).map(|v| f64::from(v) / 32_767.0);
            let half = f64::from(FRAC_1_SQRT_2);
            let expected = [0.0, half, 0.0, half];
            assert!(values.iter().zip(expected).all(|(v, e)| (v - e).abs() < 1e-3), "{values:?}");
        }
    }

    #[test]
    fn exponents_scale_exactly() {
        let stored = [(-3 << 24) | 5, (2 << 24) | (-7 & 0xff_ffff), 0];
        let mut bytes: Vec<u8> = stored.iter().flat_map(|v: &i32| v.to_le_bytes()).collect();
        exponential(&mut bytes);
        let floats: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        assert_eq!(floats, [0.625, -28.0, 0.0]);
    }

    #[test]
    fn colours_come_back() {
        // Red with half alpha, in 7 bits: 127, 0, 1 and 65.
        let mut element = vec![32, 63, (-32i8) as u8, 64 | 32];
        color(&mut element, 4);
        assert_eq!(element, [255, 0, 2, 129]);
        let mut element = shorts(&[100, 0, 0, 128 | 127]);
        color(&mut element, 8);
        let expected = (100.0f32 * 65_535.0 / 255.0).round() as u16;
        let read: Vec<u16> = element.as_chunks::<2>().0.iter().map(|b| u16::from_le_bytes(*b)).collect();
        assert_eq!(read, [expected, expected, expected, 65_535]);
    }

    #[test]
    fn what_is_not_allowed_still_gives_numbers() {
        for stride in [4, 8] {
            let mut zeros = vec![0; stride];
            octahedral(&mut zeros, stride);
            color(&mut zeros, stride);
            let mut ones = vec![255; stride];
            octahedral(&mut ones, stride);
            color(&mut ones, stride);
        }
        quaternion(&mut [0; 8]);
        quaternion(&mut [255; 8]);
        exponential(&mut [127; 4]);
    }
}
