#include "nodes/run.h"

// Compiled once a node, with the name of its function.
int main(int argc, char** argv) { return mm::MM_RUN(argc, argv); }
