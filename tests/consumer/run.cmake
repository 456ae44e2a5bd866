# SPDX-License-Identifier: MIT
file(REMOVE_RECURSE ${WORK})
set(prefix "${WORK}/a prefix")

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${CMAKE_COMMAND} --install ${ALIDADE_BUILD} --prefix ${prefix})
run(${CMAKE_COMMAND} -G Ninja -S ${CONSUMER} -B ${WORK}/build -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_BUILD_TYPE=Release
    -D CMAKE_CXX_COMPILER=${CXX} -D CMAKE_CXX_FLAGS=${CXX_FLAGS} -D WITH_RENDERER=${ALIDADE_WITH_RENDERER})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/query_points)
if(ALIDADE_WITH_RENDERER)
  run(${WORK}/build/view_points ${WORK}/view.png)
  run(${WORK}/build/see_points)
  file(WRITE ${WORK}/cloud.xyz "0 0 0\n1 0 0\n0 1 0\n1 1 1\n")
  run(${prefix}/bin/alidade render --cloud ${WORK}/cloud.xyz --size=8x8 --samples=1 -q -o ${WORK}/cloud.png)
endif()
