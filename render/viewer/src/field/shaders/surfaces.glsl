// A quarter's surface in one number, never 0: the bits of its inverse distance but the lowest
// five, a bit that is set, and around.
uint packed_surface(Surface surface) {
  return (floatBitsToUint(surface.inverse) & ~31u) | 16u | surface.around;
}
Surface unpacked_surface(uint bits) {
  return Surface(uintBitsToFloat(bits & ~31u), bits & 15u);
}
