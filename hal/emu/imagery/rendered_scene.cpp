#include "hal/emu/imagery/rendered_scene.h"

namespace stof::hal::emu {

RenderedScene::RenderedScene(const Scene& scene, const Rig& rig)
    : SensorImagery(rig),
      views_(sensors().render(scene)),
      depth_(sensors().depth(scene)),
      visible_(sensors().visible(scene)) {}

void RenderedScene::left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept {
  sensors().left(views_, number, out);
}

void RenderedScene::right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept {
  sensors().right(views_, number, out);
}

void RenderedScene::pmd(std::uint32_t number, int index,
                        dsp::ImageView<std::uint16_t> out) noexcept {
  sensors().pmd(views_, number, index, out);
}

}  // namespace stof::hal::emu
