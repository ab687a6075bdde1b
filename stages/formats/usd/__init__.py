"""Describes a robot's USD without a USD library: names, colours, drives, actuators, joints and zeros."""
