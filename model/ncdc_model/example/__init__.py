"""The built-in example: a known camera, its photo of a dot target, and a scene."""

from ncdc_model.example.camera import BAYER, example_camera
from ncdc_model.example.scene import noise_picture, scene_at, scene_light, scene_photo
from ncdc_model.example.target import page_dots, page_to_distorted, target_photo
from ncdc_model.example.truth import true_map

__all__ = ["BAYER", "example_camera", "noise_picture", "page_dots", "page_to_distorted",
           "scene_at", "scene_light", "scene_photo", "target_photo", "true_map"]
