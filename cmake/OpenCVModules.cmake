# OpenCV's core and imgproc as the target loopline_opencv, and OPENCV_imgcodecs_LIBRARY, from the three small packages
# libopencv-{core,imgproc,imgcodecs}-dev. OpenCVConfig.cmake comes only with libopencv-dev, whose 200 further packages
# (VTK, Qt, ...) a headless program has no use for.
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
add_library(loopline_opencv INTERFACE)
target_include_directories(loopline_opencv SYSTEM INTERFACE ${OPENCV_INCLUDE_DIR})
foreach(module core imgproc imgcodecs)
    find_library(OPENCV_${module}_LIBRARY opencv_${module} REQUIRED)
endforeach()
target_link_libraries(loopline_opencv INTERFACE ${OPENCV_core_LIBRARY} ${OPENCV_imgproc_LIBRARY})
