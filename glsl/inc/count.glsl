// Adds to a count of 64 bits. Wants `buffer Count { uint count[2]; }`, low word first.
void add_to_count(uint n) {
    uint before = atomicAdd(count[0], n);
    if (before + n < before) atomicAdd(count[1], 1);
}
