# How CI has Jolt built, as CMAKE_TOOLCHAIN_FILE: its sources in one piece and not optimised, a
# tenth of the time. Included a second time by Jolt's own project, since the C functions around it
# cannot be compiled in one piece.
if(PROJECT_NAME STREQUAL "JoltPhysics")
    set(CMAKE_UNITY_BUILD ON)
    set(CMAKE_UNITY_BUILD_BATCH_SIZE 0)
else()
    set(CMAKE_PROJECT_JoltPhysics_INCLUDE "${CMAKE_CURRENT_LIST_FILE}")
    set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
    set(OVERRIDE_CXX_FLAGS OFF CACHE BOOL "")
    set(CMAKE_CXX_FLAGS_RELEASE "-O0 -DJPH_NO_FORCE_INLINE" CACHE STRING "")
endif()
