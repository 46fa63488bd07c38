//! Memory that goes to the interrupt and comes back.

/// Memory in which something is made for the interrupt.
pub(crate) enum Spare<T: 'static> {
    /// Never used.
    Blank(&'static mut Option<T>),
    /// Back from its use.
    Used(&'static mut T),
}

impl<T> Spare<T> {
    /// With this in it.
    pub(crate) fn filled(self, thing: T) -> &'static mut T {
        match self {
            Self::Blank(slot) => slot.insert(thing),
            Self::Used(slot) => {
                *slot = thing;
                slot
            }
        }
    }
}
