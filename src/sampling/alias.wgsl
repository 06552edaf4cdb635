// The alias method: twin of alias.rs. The module that uses it declares `alias_slots`.

// The index that `word` draws from the table of 2^`bits` slots that begins at `first`.
fn alias_draw(first: u32, bits: u32, word: u32) -> u32 {
    let slot = word >> (32u - bits);
    let entry = alias_slots[first + slot];
    let index_mask = (1u << bits) - 1u;
    // Both sides hold the fraction in their upper bits, so they compare as they are.
    return select(entry & index_mask, slot, (word << bits) < (entry & ~index_mask));
}
