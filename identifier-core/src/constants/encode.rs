//! Parts of a configuration as words.

use core::marker::PhantomData;

use crate::unrolled::each;

/// The sum over no word: the offset of the hash FNV-1a.
pub(super) const EMPTY: u32 = 0x811c_9dc5;

/// The sum with one more word. Every step is a bijection of sum and of word. So one changed word always changes the
/// sum. A product leaves the highest bit at its place; the rotation moves it to the lower ones.
pub(super) const fn with(sum: u32, word: u32) -> u32 {
    const PRIME: u32 = 0x0100_0193;
    (sum ^ word).wrapping_mul(PRIME).rotate_left(15)
}

#[inline(never)]
pub(super) const fn checksum(words: &[u32]) -> u32 {
    let mut sum = EMPTY;
    let mut rest = words;
    while let [first, others @ ..] = rest {
        sum = with(sum, *first);
        rest = others;
    }
    sum
}

/// The fingerprint of a name and parts.
pub(crate) const fn fingerprint(name: &str, parts: &[u32]) -> u32 {
    let mut sum = EMPTY;
    let mut rest = name.as_bytes();
    while let [first, others @ ..] = rest {
        sum = with(sum, *first as u32);
        rest = others;
    }
    with(sum, checksum(parts))
}

/// The fingerprint of a field, with its name, and the number of its words.
pub(crate) const fn field<T, F: Encode>(name: &str, _: fn(&T) -> &F) -> (u32, usize) {
    (fingerprint(name, &[F::SHAPE]), F::WORDS)
}

/// The words that are still to be read.
#[derive(Debug)]
pub struct Decoder<'a> {
    words: &'a [u32],
}

impl<'a> Decoder<'a> {
    /// From the first field on.
    #[inline(always)]
    pub(super) fn new(fields: &'a [u32]) -> Self {
        Self { words: fields }
    }

    /// There is a next word, because as many are there as were checked.
    #[inline(always)]
    fn word(&mut self) -> u32 {
        match self.words {
            [first, rest @ ..] => {
                self.words = rest;
                *first
            }
            [] => 0,
        }
    }
}

/// A part of a configuration as words.
pub trait Encode: Copy {
    /// A fingerprint of its type: of the names and types of all fields.
    const SHAPE: u32;

    /// The number of its words.
    const WORDS: usize;

    /// Writes it.
    fn encode(&self, word: &mut dyn FnMut(u32));

    /// Reads it.
    fn decode(words: &mut Decoder<'_>) -> Self;
}

/// A struct as words: its fields in their order. `also` is a fingerprint of the parts that are only in its type.
macro_rules! encode {
    ([$($generics:tt)*] $own:ty as $name:literal { $($field:tt),* $(,)? } $(also $also:expr)?) => {
        impl<$($generics)*> $crate::constants::Encode for $own {
            const SHAPE: u32 = $crate::constants::fingerprint(
                $name,
                &[
                    $($crate::constants::field(stringify!($field), |own: &Self| &own.$field).0,)*
                    $($also,)?
                ],
            );
            const WORDS: usize =
                0 $(+ $crate::constants::field(stringify!($field), |own: &Self| &own.$field).1)*;

            fn encode(&self, _word: &mut dyn FnMut(u32)) {
                $($crate::constants::Encode::encode(&self.$field, _word);)*
            }

            #[inline(always)]
            fn decode(_words: &mut $crate::constants::Decoder<'_>) -> Self {
                Self { $($field: $crate::constants::Encode::decode(_words)),* }
            }
        }
    };
}

pub(crate) use encode;

/// A number of at most 32 bits.
macro_rules! encode_word {
    ($($number:ty: |$own:ident| $to:expr, |$word:ident| $from:expr;)*) => {$(
        impl Encode for $number {
            const SHAPE: u32 = fingerprint(stringify!($number), &[]);
            const WORDS: usize = 1;

            fn encode(&self, word: &mut dyn FnMut(u32)) {
                let $own = *self;
                word($to);
            }

            #[inline(always)]
            fn decode(words: &mut Decoder<'_>) -> Self {
                let $word = words.word();
                $from
            }
        }
    )*};
}

encode_word! {
    f32: |own| own.to_bits(), |word| Self::from_bits(word);
    bool: |own| own.into(), |word| word != 0;
    u8: |own| own.into(), |word| word as Self;
    u16: |own| own.into(), |word| word as Self;
    u32: |own| own, |word| word;
    i32: |own| own.cast_unsigned(), |word| word.cast_signed();
    usize: |own| own as u32, |word| word as Self;
}

/// A number of 64 bits: its lower half first.
macro_rules! encode_words {
    ($($number:ty: |$own:ident| $to:expr, |$bits:ident| $from:expr;)*) => {$(
        impl Encode for $number {
            const SHAPE: u32 = fingerprint(stringify!($number), &[]);
            const WORDS: usize = 2;

            fn encode(&self, word: &mut dyn FnMut(u32)) {
                let $own = *self;
                let bits: u64 = $to;
                word(bits as u32);
                word((bits >> 32) as u32);
            }

            #[inline(always)]
            fn decode(words: &mut Decoder<'_>) -> Self {
                let low = words.word();
                let $bits = u64::from(words.word()) << 32 | u64::from(low);
                $from
            }
        }
    )*};
}

encode_words! {
    f64: |own| own.to_bits(), |bits| Self::from_bits(bits);
    i64: |own| own.cast_unsigned(), |bits| bits.cast_signed();
}

impl<T: Encode, const P: usize> Encode for [T; P] {
    const SHAPE: u32 = fingerprint("array", &[P as u32, T::SHAPE]);
    const WORDS: usize = P * T::WORDS;

    fn encode(&self, word: &mut dyn FnMut(u32)) {
        for entry in self {
            entry.encode(word);
        }
    }

    #[inline(always)]
    fn decode(words: &mut Decoder<'_>) -> Self {
        // Written out, or nothing of it is known to the optimiser at its level for size.
        let mut entries = [T::decode(words); P];
        each::<P>(|i| {
            if i > 0 {
                entries[i] = T::decode(words);
            }
        });
        entries
    }
}

impl<A: Encode, B: Encode> Encode for (A, B) {
    const SHAPE: u32 = fingerprint("both", &[A::SHAPE, B::SHAPE]);
    const WORDS: usize = A::WORDS + B::WORDS;

    fn encode(&self, word: &mut dyn FnMut(u32)) {
        self.0.encode(word);
        self.1.encode(word);
    }

    #[inline(always)]
    fn decode(words: &mut Decoder<'_>) -> Self {
        (A::decode(words), B::decode(words))
    }
}

impl<T: Encode> Encode for Option<T> {
    const SHAPE: u32 = fingerprint("option", &[T::SHAPE]);
    const WORDS: usize = 1 + T::WORDS;

    fn encode(&self, word: &mut dyn FnMut(u32)) {
        self.is_some().encode(word);
        match self {
            Some(value) => value.encode(word),
            None => (0..T::WORDS).for_each(|_| word(0)),
        }
    }

    #[inline(always)]
    fn decode(words: &mut Decoder<'_>) -> Self {
        let is_some = bool::decode(words);
        let value = T::decode(words);
        is_some.then_some(value)
    }
}

impl Encode for () {
    const SHAPE: u32 = fingerprint("nothing", &[]);
    const WORDS: usize = 0;

    fn encode(&self, _: &mut dyn FnMut(u32)) {}

    #[inline(always)]
    fn decode(_: &mut Decoder<'_>) {}
}

/// A type without words. A struct that holds it names its fingerprint.
impl<T> Encode for PhantomData<T> {
    const SHAPE: u32 = fingerprint("type", &[]);
    const WORDS: usize = 0;

    fn encode(&self, _: &mut dyn FnMut(u32)) {}

    #[inline(always)]
    fn decode(_: &mut Decoder<'_>) -> Self {
        Self
    }
}
