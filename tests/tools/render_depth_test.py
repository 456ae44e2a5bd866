# SPDX-License-Identifier: MIT
# render_depth_test.py MODULE: what MODULE (numpy, cv2, open3d) reads from the maps 0.npy, 0.png, ... of one camera,
# against the float32 values in raw (height 16, width 24). The camera stands at (101, 201, 9) and looks down on the
# plane z = 5; fx = fy = 20, cx = 12, cy = 8.
import os, sys
os.environ['OPENCV_IO_ENABLE_OPENEXR'] = '1'
import numpy as np
raw = np.fromfile('raw', '<f4').reshape(16, 24)
steps = np.where(raw > 0, np.maximum(np.floor(raw.astype('f8') * 1000 + 0.5), 1), 0)
assert (raw > 0).any() and (raw == 0).any()
if sys.argv[1] == 'numpy':
    map = np.load('0.npy')
    assert map.dtype == '<f4' and map.flags.c_contiguous and (map == raw).all()
    # As COLMAP's own script read_write_dense.py reads it: columns first.
    width, height, channels, values = open('0.bin', 'rb').read().split(b'&', 3)
    map = np.frombuffer(values, '<f4').reshape((int(width), int(height), int(channels)), order='F')
    assert (np.transpose(map, (1, 0, 2)).squeeze() == raw).all()
elif sys.argv[1] == 'cv2':
    import cv2
    for name in ('0.tif', '0.exr'):
        for mode in (cv2.IMREAD_UNCHANGED, cv2.IMREAD_ANYDEPTH):
            map = cv2.imread(name, mode)
            assert map.dtype == np.float32 and (map == raw).all(), name
    map = cv2.imread('0.png', cv2.IMREAD_ANYDEPTH)
    assert map.dtype == np.uint16 and (map == steps).all()
    mask = cv2.imread('mask.png', cv2.IMREAD_UNCHANGED)
    assert mask.dtype == np.uint8 and (mask == np.where(raw > 0, 255, 0)).all()
else:
    import open3d
    map = open3d.io.read_image('0.png')
    assert np.asarray(map).dtype == np.uint16 and (np.asarray(map) == steps).all()
    mask = np.asarray(open3d.io.read_image('mask.png'))
    assert mask.dtype == np.uint8 and (mask == np.where(raw > 0, 255, 0)).all()
    # Open3D counts pixels from their centres.
    intrinsic = open3d.camera.PinholeCameraIntrinsic(24, 16, 20, 20, 12 - 0.5, 8 - 0.5)
    extrinsic = np.array([[1, 0, 0, -101], [0, -1, 0, 201], [0, 0, -1, 9], [0, 0, 0, 1.0]])
    # It reads no floats from files: those of NumPy are exact.
    for depths, scale, error in ((map, 1000.0, 0.002), (open3d.geometry.Image(np.load('0.npy')), 1.0, 1e-5)):
        cloud = open3d.geometry.PointCloud.create_from_depth_image(depths, intrinsic, extrinsic, depth_scale=scale)
        points = np.asarray(cloud.points)
        assert len(points) == (raw > 0).sum()
        assert abs(points[:, 2] - 5).max() < error, points
        assert points[:, 0].min() > 99.7 and points[:, 0].max() < 102.2, points
