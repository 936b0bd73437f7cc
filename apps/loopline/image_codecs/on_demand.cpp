/// OpenCV's image files, loaded when the first one is read or written.
///
/// libmrpt-img needs libopencv_imgcodecs, which brings GDAL and a hundred libraries more: loading and
/// relocating them is most of what a program on MRPT takes to start, and few runs touch an image file. This
/// library bears the name of OpenCV's, so that whoever needs that one in this process gets this one, and
/// passes each call on to it.
#include <dlfcn.h>

#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

namespace {

/// The function of OpenCV's own library that bears the same symbol as one of this library.
template <class Function>
Function* original(Function* own) {
    static void* const library = ::dlopen(LOOPLINE_OPENCV_IMGCODECS, RTLD_NOW | RTLD_LOCAL);
    Dl_info symbol{};
    ::dladdr(reinterpret_cast<void*>(own), &symbol);
    void* const function = library != nullptr ? ::dlsym(library, symbol.dli_sname) : nullptr;
    if (function == nullptr) {
        const char* const reason = ::dlerror();
        throw std::runtime_error(std::string("image files can't be read or written (") +
                                 (reason != nullptr ? reason : LOOPLINE_OPENCV_IMGCODECS) +
                                 "); install OpenCV's imgcodecs again");
    }
    return reinterpret_cast<Function*>(function);
}

using Bytes = std::vector<uchar>;
using Integers = std::vector<int>;
using Images = std::vector<cv::Mat>;

}  // namespace

namespace cv {

Mat imread(const String& filename, int flags) {
    return original<Mat(const String&, int)>(imread)(filename, flags);
}
bool imreadmulti(const String& filename, Images& mats, int flags) {
    return original<bool(const String&, Images&, int)>(imreadmulti)(filename, mats, flags);
}
bool imreadmulti(const String& filename, Images& mats, int start, int count, int flags) {
    return original<bool(const String&, Images&, int, int, int)>(imreadmulti)(filename, mats, start, count,
                                                                              flags);
}
size_t imcount(const String& filename, int flags) {
    return original<size_t(const String&, int)>(imcount)(filename, flags);
}
bool imwrite(const String& filename, InputArray img, const Integers& params) {
    return original<bool(const String&, InputArray, const Integers&)>(imwrite)(filename, img, params);
}
Mat imdecode(InputArray buf, int flags) {
    return original<Mat(InputArray, int)>(imdecode)(buf, flags);
}
Mat imdecode(InputArray buf, int flags, Mat* dst) {
    return original<Mat(InputArray, int, Mat*)>(imdecode)(buf, flags, dst);
}
bool imencode(const String& ext, InputArray img, Bytes& buf, const Integers& params) {
    return original<bool(const String&, InputArray, Bytes&, const Integers&)>(imencode)(ext, img, buf,
                                                                                        params);
}
bool haveImageReader(const String& filename) {
    return original<bool(const String&)>(haveImageReader)(filename);
}
bool haveImageWriter(const String& filename) {
    return original<bool(const String&)>(haveImageWriter)(filename);
}

}  // namespace cv
