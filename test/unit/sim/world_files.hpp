#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace frugal_nav::sim::test {

/// A world file around some elements.
inline std::string worldText(const std::string& elements) {
  return "<?xml version='1.0'?>\n<sdf version='1.6'>\n<world name='test'>\n" + elements +
         "\n</world>\n</sdf>\n";
}

/// A static model around some elements of its only link.
inline std::string modelText(const std::string& name, const std::string& elements,
                             const std::string& pose = "0 0 0 0 0 0") {
  return "<model name='" + name + "'><static>true</static><pose>" + pose + "</pose><link name='link'>" +
         elements + "</link></model>";
}

inline std::string visualText(const std::string& geometry, const std::string& more = "") {
  return "<visual name='visual'><geometry>" + geometry + "</geometry>" + more + "</visual>";
}

inline std::string collisionText(const std::string& geometry) {
  return "<collision name='collision'><geometry>" + geometry + "</geometry></collision>";
}

inline std::string meshText(const std::string& uri, const std::string& more = "") {
  return "<mesh><uri>" + uri + "</uri>" + more + "</mesh>";
}

/// A DAE of one triangle with corners (0 0 0), (100 0 0), (0 0 100), unit cm, up axis as given, with a
/// texture when an image is named.
inline std::string daeText(const std::string& up_axis, const std::string& image = "") {
  const std::string images = image.empty() ? ""
                                           : "<library_images><image id='img'><init_from>" + image +
                                                 "</init_from></image></library_images>";
  const std::string parameters =
      image.empty() ? ""
                    : "<newparam sid='sf'><surface type='2D'><init_from>img</init_from></surface></newparam>"
                      "<newparam sid='sm'><sampler2D><source>sf</source></sampler2D></newparam>";
  const std::string diffuse =
      image.empty() ? "<color>0.2 0.4 0.6 1</color>" : "<texture texture='sm' texcoord='UV'/>";
  return "<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>"
         "<asset><unit name='centimeter' meter='0.01'/><up_axis>" +
         up_axis + "</up_axis></asset>" + images + "<library_effects><effect id='fx'><profile_COMMON>" +
         parameters + "<technique sid='c'><lambert><diffuse>" + diffuse +
         "</diffuse></lambert></technique></profile_COMMON></effect></library_effects>"
         "<library_materials><material id='mat'><instance_effect url='#fx'/></material></library_materials>"
         "<library_geometries><geometry id='tri' name='tri'><mesh>"
         "<source id='p'><float_array id='pa' count='9'>0 0 0 100 0 0 0 0 100</float_array><technique_common>"
         "<accessor source='#pa' count='3' stride='3'><param name='X' type='float'/><param name='Y' "
         "type='float'/>"
         "<param name='Z' type='float'/></accessor></technique_common></source>"
         "<source id='t'><float_array id='ta' count='6'>0 0 1 0 0 1</float_array><technique_common>"
         "<accessor source='#ta' count='3' stride='2'><param name='S' type='float'/><param name='T' "
         "type='float'/>"
         "</accessor></technique_common></source>"
         "<vertices id='v'><input semantic='POSITION' source='#p'/></vertices>"
         "<triangles count='1' material='m'><input semantic='VERTEX' source='#v' offset='0'/>"
         "<input semantic='TEXCOORD' source='#t' offset='1'/><p>0 0 1 1 2 2</p></triangles></mesh></geometry>"
         "</library_geometries><library_visual_scenes><visual_scene id='s'><node id='n' name='part'>"
         "<instance_geometry url='#tri'><bind_material><technique_common><instance_material symbol='m' "
         "target='#mat'/></technique_common></bind_material></instance_geometry></node></visual_scene>"
         "</library_visual_scenes><scene><instance_visual_scene url='#s'/></scene></COLLADA>";
}

/// An image of one colour, given as red, green, blue.
inline std::string pngBytes(int width_px, int height_px, int red, int green, int blue) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", cv::Mat(height_px, width_px, CV_8UC3, cv::Scalar(blue, green, red)), bytes);
  return {bytes.begin(), bytes.end()};
}

/// Whether one of the texts contains all of the words.
inline bool mentions(const std::vector<std::string>& texts, const std::vector<std::string>& words) {
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& text) {
    return std::all_of(words.begin(), words.end(),
                       [&](const std::string& word) { return text.find(word) != std::string::npos; });
  });
}

}  // namespace frugal_nav::sim::test
