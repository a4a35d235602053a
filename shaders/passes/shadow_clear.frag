// Empties a tile of a shadow map: the triangle's depth, 0, is all that is written.
void main() {}
