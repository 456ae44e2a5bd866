// SPDX-License-Identifier: MIT
// text_seeds FOLDER: small XYZ, CSV, PTS and PTX files as a start for fuzz_text.
#include <vector>

#include "tests/fuzz/write_seeds.h"

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const std::string pose = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  const std::vector<std::string> seeds{
      "1.5 2.5 3.5\n4 5 6\n",
      "# x y z a\n1 2 3 4\n// c\n+1e3 nan -.5 6\n",
      "1;2;3;-100;255;0;1;0;0.6;-0.8;\n",
      "\xEF\xBB\xBF\"id\",x,y,z,r,g,b,intensity,class,time,word\n1,1.25,2,3,4,5,6,7,8,9.5,\"a,b\"\n2,1,2,3,4,"
      "5,6,7,8,,\n",
      "//Y;X;Z;Classification;GpsTime [ms];a (m)\r1\r5,5;-;3,25;2;nil;\r",
      "x [ft]\ty [ft]\tz [us-ft]\ti\n1\n1,5\t2\t3\tNA\n",
      "2\n1 2 3 -2048 255 0 1\n4 5 6 2047 0 0 0\n1\n7 8 9 0 1 2 3\n",
      "1\n2\n" + pose + "0 1 0 0\n-1 0 0 0\n0 0 1 0\n9 9 9 1\n1.5 2 3 0.5 1 2 3\n0 0 0 0.5 0 0 0\n1\n1\n" +
          pose + "1 0 0 5\n0 1 0 5\n0 0 1 5\n0 0 0 1\n1 2 3 0.5\n"};
  return alidade::test::write_seeds(arguments[1], seeds);
}
