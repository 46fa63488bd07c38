// The parts of the page out of their text: base 91, then a raw stream of LZMA with three bits of context for literals and none for positions
// (Pavlov, LZMA specification, 2015).

// Bytes of a text in base 91: two digits, the characters from ! to | without <, are 13 bits.
function bytesOf(text) {
  const digit = (i) => text.charCodeAt(i) - (text.charCodeAt(i) > 60 ? 34 : 33);
  const bytes = new Uint8Array(text.length * 13 / 16);
  for (let i = 0, o = 0, waiting = 0, count = 0; i < text.length; i += 2) {
    waiting = (waiting << 13) | (digit(i) * 91 + digit(i + 1));
    for (count += 13; count >= 8; ) bytes[o++] = waiting >>> (count -= 8);
    waiting &= (1 << count) - 1;
  }
  return bytes;
}

// The bytes that a packed stream holds, `length` of them.
function unpack(packed, length) {
  const out = new Uint8Array(length);
  const even = (count) => new Uint16Array(count).fill(1024);
  let at = 5, range = 0xffffffff, code = 0;
  for (let i = 1; i < 5; i++) code = ((code << 8) | packed[i]) >>> 0;

  const bit = (odds, i) => {
    const bound = (range >>> 11) * odds[i];
    let value;
    if (code < bound) {
      range = bound;
      odds[i] += (2048 - odds[i]) >>> 5;
      value = 0;
    } else {
      code = (code - bound) >>> 0;
      range = (range - bound) >>> 0;
      odds[i] -= odds[i] >>> 5;
      value = 1;
    }
    if (range < 0x1000000) {
      range = (range << 8) >>> 0;
      code = ((code << 8) | packed[at++]) >>> 0;
    }
    return value;
  };
  const direct = (count) => {
    let value = 0;
    while (count-- > 0) {
      range >>>= 1;
      const one = code >= range ? 1 : 0;
      if (one) code = (code - range) >>> 0;
      if (range < 0x1000000) {
        range = (range << 8) >>> 0;
        code = ((code << 8) | packed[at++]) >>> 0;
      }
      value = (value << 1) | one;
    }
    return value;
  };
  const tree = (odds, from, bits) => {
    let place = 1;
    for (let i = 0; i < bits; i++) place = (place << 1) | bit(odds, from + place);
    return place - (1 << bits);
  };
  const reverse = (odds, from, bits) => {
    let place = 1, value = 0;
    for (let i = 0; i < bits; i++) {
      const one = bit(odds, from + place);
      place = (place << 1) | one;
      value |= one << i;
    }
    return value;
  };
  const lengths = () => ({ choice: even(2), low: even(8), middle: even(8), high: even(256) });
  const lengthOf = (of) => {
    if (!bit(of.choice, 0)) return 2 + tree(of.low, 0, 3);
    if (!bit(of.choice, 1)) return 10 + tree(of.middle, 0, 3);
    return 18 + tree(of.high, 0, 8);
  };

  const literal = even(0x1800), isMatch = even(12), isRepeat = even(12);
  const isLater = even(12), isLong = even(12), isSecond = even(12), isThird = even(12);
  const slots = [even(64), even(64), even(64), even(64)];
  const near = even(128), align = even(16), match = lengths(), repeat = lengths();
  let state = 0, end = 0;
  let [first, second, third, fourth] = [0, 0, 0, 0];

  while (end < length) {
    if (!bit(isMatch, state)) {
      let symbol = 1;
      const from = 0x300 * (out[end - 1] >> 5);
      if (state >= 7) {
        let other = out[end - first - 1];
        do {
          const expected = (other >> 7) & 1;
          other <<= 1;
          const one = bit(literal, from + ((1 + expected) << 8) + symbol);
          symbol = (symbol << 1) | one;
          if (expected !== one) break;
        } while (symbol < 0x100);
      }
      while (symbol < 0x100) symbol = (symbol << 1) | bit(literal, from + symbol);
      out[end++] = symbol;
      state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
      continue;
    }
    let count;
    if (bit(isRepeat, state)) {
      if (!bit(isLater, state)) {
        if (!bit(isLong, state)) {
          state = state < 7 ? 9 : 11;
          out[end] = out[end - first - 1];
          end++;
          continue;
        }
      } else {
        let distance;
        if (!bit(isSecond, state)) {
          distance = second;
        } else {
          if (!bit(isThird, state)) {
            distance = third;
          } else {
            distance = fourth;
            fourth = third;
          }
          third = second;
        }
        second = first;
        first = distance;
      }
      count = lengthOf(repeat);
      state = state < 7 ? 8 : 11;
    } else {
      [fourth, third, second] = [third, second, first];
      count = lengthOf(match);
      state = state < 7 ? 7 : 10;
      const slot = tree(slots[Math.min(count - 2, 3)], 0, 6);
      if (slot < 4) {
        first = slot;
      } else {
        const bits = (slot >> 1) - 1;
        first = (2 | (slot & 1)) << bits;
        if (slot < 14) first += reverse(near, first - slot, bits);
        else first += (direct(bits - 4) << 4) + reverse(align, 0, 4);
      }
    }
    for (let i = 0; i < count && end < length; i++, end++) out[end] = out[end - first - 1];
  }
  return out;
}
